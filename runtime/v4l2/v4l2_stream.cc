#include "v4l2_stream.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

#include "v4l2_formats.h"

namespace raygrid {
namespace {

// Fields common to both buffer types, at different offsets.
struct Picture {
  uint32_t code, width, height, field;
  bool is_full_range;
};

// Whether black and white are 0 and 255 in YUV, instead of 16 and 235.
bool IsFullRange(uint32_t colour_space, uint32_t quantization) {
  if (quantization == V4L2_QUANTIZATION_DEFAULT)
    return colour_space == V4L2_COLORSPACE_JPEG;
  return quantization == V4L2_QUANTIZATION_FULL_RANGE;
}

v4l2_format MakeFormat(uint32_t buffer_type, uint32_t code, unsigned width,
                       unsigned height) {
  v4l2_format format = {};
  format.type = buffer_type;
  if (buffer_type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
    format.fmt.pix_mp.pixelformat = code;
    format.fmt.pix_mp.width = width;
    format.fmt.pix_mp.height = height;
    format.fmt.pix_mp.field = V4L2_FIELD_NONE;
  } else {
    format.fmt.pix.pixelformat = code;
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.field = V4L2_FIELD_NONE;
  }
  return format;
}

Picture GetPictureFormat(const v4l2_format& format) {
  if (format.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
    const v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
    return {pix.pixelformat, pix.width, pix.height, pix.field,
            IsFullRange(pix.colorspace, pix.quantization)};
  }
  const v4l2_pix_format& pix = format.fmt.pix;
  return {pix.pixelformat, pix.width, pix.height, pix.field,
          IsFullRange(pix.colorspace, pix.quantization)};
}

// Returns all codes: the current one, then those that the device lists.
std::vector<uint32_t> ListCodes(V4l2Device* device, uint32_t buffer_type) {
  std::vector<uint32_t> codes;
  v4l2_format own = {};
  own.type = buffer_type;
  if (IoctlWithRetry(device, VIDIOC_G_FMT, &own) == 0)
    codes.push_back(GetPictureFormat(own).code);
  v4l2_fmtdesc listed = {};
  listed.type = buffer_type;
  for (; IoctlWithRetry(device, VIDIOC_ENUM_FMT, &listed) == 0; ++listed.index)
    codes.push_back(listed.pixelformat);
  return codes;
}

// Returns the codes of JPEG formats, or of supported pixel formats, among
// `codes`; if a name is given, only those with this name.
std::vector<uint32_t> FindCandidates(std::vector<uint32_t> codes,
                                     const std::string& name, bool are_jpegs) {
  const auto is_useless = [&name, are_jpegs](uint32_t code) {
    return !(are_jpegs ? IsJpegFormat(code)
                       : FindV4l2Format(code) != nullptr) ||
           (!name.empty() && name != V4l2FormatName(code));
  };
  codes.erase(std::remove_if(codes.begin(), codes.end(), is_useless),
              codes.end());
  return codes;
}

struct Choice {
  v4l2_format format;
  bool has_size;  // otherwise the device adjusts it
};

// Returns the first format with exactly the given size; otherwise the first
// whose size the device would adjust.
std::optional<Choice> FindFormat(V4l2Device* device, uint32_t buffer_type,
                                 const std::vector<uint32_t>& codes,
                                 unsigned width, unsigned height) {
  std::optional<Choice> adjusted;
  for (const uint32_t code : codes) {
    v4l2_format format = MakeFormat(buffer_type, code, width, height);
    const int status = IoctlWithRetry(device, VIDIOC_TRY_FMT, &format);
    // A driver may lack this ioctl.
    if (status != 0 && status != ENOTTY) continue;
    const Picture picture = GetPictureFormat(format);
    if (picture.code != code) continue;
    if (picture.width == width && picture.height == height)
      return Choice{format, true};
    if (!adjusted) adjusted = Choice{format, false};
  }
  return adjusted;
}

// Returns the remedy for a name that no format of the device has.
std::string DescribeRemedy(const std::string& name) {
  const std::string other = DescribeOtherName(name);
  return other.empty() ? "see --list" : other;
}

// Returns the best pixel format; JPEG only if no other format has the size.
v4l2_format ChooseFormat(V4l2Device* device, uint32_t buffer_type,
                         const std::string& name, unsigned width,
                         unsigned height, bool takes_jpegs) {
  const std::vector<uint32_t> codes = ListCodes(device, buffer_type);
  const std::vector<uint32_t> pixels = FindCandidates(codes, name, false);
  std::vector<uint32_t> jpegs;
  if (takes_jpegs) jpegs = FindCandidates(codes, name, true);
  if (pixels.empty() && jpegs.empty())
    throw V4l2Error(
        *device, "has no pixel format " +
                     (name.empty() ? "that can be undistorted" : name) + "; " +
                     DescribeRemedy(name));
  const auto choice = FindFormat(device, buffer_type, pixels, width, height);
  if (choice && choice->has_size) return choice->format;
  const auto other = FindFormat(device, buffer_type, jpegs, width, height);
  if (other && (other->has_size || !choice)) return other->format;
  if (choice) return choice->format;
  throw V4l2Error(*device,
                  "rejects all of its formats; use a --format from --list");
}

bool HasWholeFrames(uint32_t field) {
  return field == V4L2_FIELD_NONE || field == V4L2_FIELD_ANY ||
         field == V4L2_FIELD_INTERLACED || field == V4L2_FIELD_INTERLACED_TB ||
         field == V4L2_FIELD_INTERLACED_BT;
}

// Reads strides and buffer sizes from the driver's format.
void TakeLayout(const v4l2_format& format, V4l2Stream* stream) {
  const Picture picture = GetPictureFormat(format);
  uint32_t strides[3] = {};
  if (stream->is_multiplanar()) {
    const v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
    stream->num_mem_planes = std::min<uint32_t>(pix.num_planes, 3);
    for (uint32_t i = 0; i < stream->num_mem_planes; ++i) {
      strides[i] = pix.plane_fmt[i].bytesperline;
      stream->mem_plane_sizes[i] = pix.plane_fmt[i].sizeimage;
    }
  } else {
    stream->num_mem_planes = 1;
    strides[0] = format.fmt.pix.bytesperline;
    stream->mem_plane_sizes[0] = format.fmt.pix.sizeimage;
  }
  stream->is_jpeg = IsJpegFormat(picture.code);
  if (stream->is_jpeg) {
    stream->format = MakeStreamFormat(*FindPixelFormat("BGR888"), picture.width,
                                      picture.height, 0);
    return;
  }
  stream->format = MakeStreamFormat(*FindV4l2Format(picture.code),
                                    picture.width, picture.height, strides[0]);
  stream->format.is_full_range = picture.is_full_range;
  for (uint32_t i = 1; i < stream->num_mem_planes; ++i)
    if (strides[i] != 0) stream->format.planes[i].stride = strides[i];
}

// Locates the planes: each in its own memory plane, or contiguous in one.
void PlacePlanes(const V4l2Device& device, V4l2Stream* stream) {
  const CameraError too_small = V4l2Error(
      device, "delivers buffers smaller than its frames; use another --format");
  const bool are_apart =
      stream->num_mem_planes == uint32_t(stream->format.num_planes);
  if (!are_apart && stream->num_mem_planes != 1) throw too_small;
  uint32_t behind = 0;
  for (int i = 0; i < stream->format.num_planes; ++i) {
    const PlaneLayout& plane = stream->format.planes[i];
    const uint32_t mem_plane = are_apart ? static_cast<uint32_t>(i) : 0;
    stream->places[i] = {mem_plane, are_apart ? 0 : behind};
    behind += plane.stride * plane.rows;
    if (plane.stride < plane.row_bytes ||
        stream->places[i].offset + plane.extent() >
            stream->mem_plane_sizes[mem_plane])
      throw too_small;
  }
}

}  // namespace

CameraError V4l2Error(const V4l2Device& device, const std::string& what) {
  return CameraError(CameraExit::kInput, device.path() + ": " + what);
}

CameraError V4l2Error(const V4l2Device& device, const std::string& words,
                      int error, const std::string& remedy) {
  if (error == EBUSY)
    return V4l2Error(device, "in use by another process; stop it first");
  if (error == ENODEV) return V4l2Error(device, "disconnected; reconnect it");
  return V4l2Error(device,
                   words + " (" + std::strerror(error) + "); " + remedy);
}

uint32_t FindBufferType(V4l2Device* device) {
  v4l2_capability capability = {};
  const int status = IoctlWithRetry(device, VIDIOC_QUERYCAP, &capability);
  if (status != 0)
    throw V4l2Error(*device, "does not respond", status, "see --list");
  const uint32_t can = capability.capabilities & V4L2_CAP_DEVICE_CAPS
                           ? capability.device_caps
                           : capability.capabilities;
  if (can & V4L2_CAP_STREAMING) {
    if (can & V4L2_CAP_VIDEO_CAPTURE) return V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (can & V4L2_CAP_VIDEO_CAPTURE_MPLANE)
      return V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  }
  throw V4l2Error(*device,
                  "does not deliver frames; use another device from --list");
}

V4l2Stream ChooseStream(V4l2Device* device, const std::string& name,
                        unsigned width, unsigned height, bool takes_jpegs) {
  V4l2Stream stream = {};
  stream.buffer_type = FindBufferType(device);
  v4l2_format format = ChooseFormat(device, stream.buffer_type, name, width,
                                    height, takes_jpegs);
  const uint32_t code = GetPictureFormat(format).code;
  const int status = IoctlWithRetry(device, VIDIOC_S_FMT, &format);
  if (status != 0)
    throw V4l2Error(*device, "rejects the format", status,
                    "use a --format and --size from --list");
  if (GetPictureFormat(format).code != code)
    throw V4l2Error(
        *device, "delivers " + V4l2FormatName(GetPictureFormat(format).code) +
                     " at that size; use another --format from --list");
  if (!HasWholeFrames(GetPictureFormat(format).field))
    throw V4l2Error(
        *device,
        "delivers interlaced fields; use a --size with progressive frames");
  TakeLayout(format, &stream);
  if (!stream.is_jpeg) PlacePlanes(*device, &stream);
  return stream;
}

}  // namespace raygrid
