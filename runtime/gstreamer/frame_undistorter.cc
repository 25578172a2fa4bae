#include "frame_undistorter.h"

#include <algorithm>
#include <cmath>

#include "camera_error.h"

namespace raygrid {
namespace {

// A buffer's planes, mapped during the object's lifetime.
class MappedFrame {
 public:
  MappedFrame(GstBuffer* buffer, const FrameLayout& layout, GstMapFlags flags)
      : buffer_(buffer), is_bayer_(layout.is_bayer) {
    if (is_bayer_) {
      is_mapped_ = gst_buffer_map(buffer, &bytes_, flags) != FALSE;
      if (is_mapped_ && bytes_.size < layout.num_bytes) Unmap();
    } else {
      is_mapped_ = gst_video_frame_map(
                       &frame_, &layout.info, buffer,
                       static_cast<GstMapFlags>(
                           flags | GST_VIDEO_FRAME_MAP_FLAG_NO_REF)) != FALSE;
    }
    if (!is_mapped_)
      throw CameraError(CameraExit::kInput,
                        "cannot map a buffer, or it is too small for its caps; "
                        "check the upstream element");
    for (int i = 0; i < layout.format.num_planes; ++i) {
      planes_[i] =
          is_bayer_
              ? bytes_.data
              : static_cast<uint8_t*>(GST_VIDEO_FRAME_PLANE_DATA(&frame_, i));
      strides_[i] =
          is_bayer_
              ? layout.format.planes[i].stride
              : static_cast<uint32_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame_, i));
    }
  }
  ~MappedFrame() {
    if (is_mapped_) Unmap();
  }
  MappedFrame(const MappedFrame&) = delete;
  MappedFrame& operator=(const MappedFrame&) = delete;

  uint8_t* plane(int i) const { return planes_[i]; }
  uint32_t stride(int i) const { return strides_[i]; }

 private:
  void Unmap() {
    if (is_bayer_)
      gst_buffer_unmap(buffer_, &bytes_);
    else
      gst_video_frame_unmap(&frame_);
    is_mapped_ = false;
  }

  GstBuffer* const buffer_;
  const bool is_bayer_;
  bool is_mapped_ = false;
  GstMapInfo bytes_;
  GstVideoFrame frame_;
  uint8_t* planes_[3] = {};
  uint32_t strides_[3] = {};
};

rg_target BlankTarget(const FrameLayout& views,
                      const UndistortSettings& settings) {
  rg_target target = {};
  target.num_rows = views.format.height;
  target.border = settings.border;
  target.sampling = settings.sampling;
  target.kernels = rg_find_kernels(nullptr);
  SetBlackBorder(views.format, &target);
  return target;
}

// The smallest rectangle of whole pixels around points.
struct Bounds {
  double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;

  void Add(const rg_pixel& pixel) {
    const double x = pixel.x_q16 / 65536.0, y = pixel.y_q16 / 65536.0;
    x0 = std::min(x0, x);
    y0 = std::min(y0, y);
    x1 = std::max(x1, x);
    y1 = std::max(y1, y);
  }
};

// The bounds of a rectangle's edges in the view. Straight edges become curves
// there, so the corners do not suffice.
std::optional<Bounds> BoundsInView(const rg_camera& camera,
                                   const GstVideoRegionOfInterestMeta& region) {
  constexpr int kSteps = 16;
  rg_mode mode;
  rg_view view;
  // For an inverse table, source frames are the view's, and
  // rg_undistort_point() has the opposite direction.
  if (rg_remap_mode(&camera, &mode) != RG_OK ||
      rg_remap_view(&camera, &view) != RG_OK || view.distorts ||
      region.w == 0 || region.h == 0)
    return std::nullopt;
  Bounds bounds;
  bool is_seen = false;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      if (i % kSteps != 0 && j % kSteps != 0) continue;
      const auto at = [](guint start, guint span, int step) {
        return static_cast<int32_t>((start + (span - 1.0) * step / kSteps) *
                                    65536);
      };
      const rg_pixel pixel = {at(region.x, region.w, i),
                              at(region.y, region.h, j)};
      rg_pixel calibrated, seen;
      if (rg_mode_to_calibrated(&mode, pixel, &calibrated) != RG_OK ||
          rg_undistort_point(&camera, calibrated, &seen) != RG_OK)
        continue;
      bounds.Add(seen);
      is_seen = true;
    }
  if (!is_seen) return std::nullopt;
  return bounds;
}

}  // namespace

FrameUndistorter::FrameUndistorter(const UndistortSettings& settings)
    : settings_(settings),
      blob_(settings.blob),
      tables_(blob_.Tables(settings.table)),
      bands_(settings.num_threads) {}

void FrameUndistorter::RequireTableFor(const GstCaps* frames) const {
  const GstStructure* const structure = gst_caps_get_structure(frames, 0);
  int width = 0, height = 0;
  if (gst_structure_get_int(structure, "width", &width) &&
      gst_structure_get_int(structure, "height", &height))
    blob_.RequireTableFor(settings_.table, width, height);
}

void FrameUndistorter::SetCaps(const GstCaps* frames, const GstCaps* views) {
  frames_ = ParseLayout(frames);
  views_ = ParseLayout(views);
  if (!frames_ || !views_)
    throw CameraError(CameraExit::kInput,
                      "frame size not supported by this format; subsampled "
                      "chroma needs even width and height");
  blob_.SelectTable(settings_.table,
                    {frames_->format.width, frames_->format.height,
                     views_->format.width, views_->format.height});
  invalid_.reset();
  if (!settings_.only_valid) return;
  invalid_.emplace(blob_.camera(), views_->format,
                   BlankTarget(*views_, settings_));
  if (invalid_->are_all())
    throw CameraError(CameraExit::kBlob,
                      settings_.blob +
                          ": its remap table has no pixel in the valid region; "
                          "set outside=fill, or pack another output view");
}

void FrameUndistorter::Undistort(GstBuffer* frame, GstBuffer* view) {
  const MappedFrame source(frame, *frames_, GST_MAP_READ);
  const MappedFrame made(view, *views_, GST_MAP_WRITE);
  const uint8_t* planes[3] = {};
  for (int i = 0; i < frames_->format.num_planes; ++i)
    planes[i] = source.plane(i);
  rg_image image = MakeImage(frames_->format, planes);
  rg_target target = BlankTarget(*views_, settings_);
  for (int i = 0; i < frames_->format.num_planes; ++i) {
    image.planes[i].stride = source.stride(i);
    target.planes[i].data = made.plane(i);
    target.planes[i].stride = made.stride(i);
  }
  const rg_status status =
      bands_.Remap(blob_.camera(), image, views_->format, target);
  if (status != RG_OK)
    throw CameraError(CameraExit::kBlob,
                      settings_.blob + ": " + rg_status_text(status));
  if (invalid_) invalid_->FillWithBorder(target);
}

void FrameUndistorter::MoveRegions(GstBuffer* frame, GstBuffer* view) const {
  gpointer state = nullptr;
  while (GstMeta* const meta = gst_buffer_iterate_meta_filtered(
             frame, &state, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE)) {
    const auto& region = *reinterpret_cast<GstVideoRegionOfInterestMeta*>(meta);
    const std::optional<Bounds> bounds = BoundsInView(blob_.camera(), region);
    if (!bounds) continue;
    const double width = views_->format.width, height = views_->format.height;
    const double x0 = std::clamp(std::floor(bounds->x0 + 0.5), 0.0, width);
    const double y0 = std::clamp(std::floor(bounds->y0 + 0.5), 0.0, height);
    const double x1 = std::clamp(std::floor(bounds->x1 + 1.5), 0.0, width);
    const double y1 = std::clamp(std::floor(bounds->y1 + 1.5), 0.0, height);
    if (x1 <= x0 || y1 <= y0) continue;
    GstVideoRegionOfInterestMeta* const moved =
        gst_buffer_add_video_region_of_interest_meta_id(
            view, region.roi_type, static_cast<guint>(x0),
            static_cast<guint>(y0), static_cast<guint>(x1 - x0),
            static_cast<guint>(y1 - y0));
    moved->id = region.id;
    moved->parent_id = region.parent_id;
    for (GList* one = region.params; one; one = one->next)
      gst_video_region_of_interest_meta_add_param(
          moved, gst_structure_copy(static_cast<GstStructure*>(one->data)));
  }
}

}  // namespace raygrid
