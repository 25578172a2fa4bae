#include "undistort_element.h"

#include <gst/video/gstvideometa.h>
#include <gst/video/gstvideopool.h>

#include <cmath>
#include <memory>
#include <mutex>
#include <string>

#include "camera_error.h"
#include "frame_undistorter.h"

namespace {

GST_DEBUG_CATEGORY_STATIC(undistort_debug);
#define GST_CAT_DEFAULT undistort_debug

// ---- Enumerations as properties --------------------------------------------

enum Outside { kFill, kValid };

GType OutsideType() {
  static const GEnumValue kValues[] = {
      {kFill, "Extrapolate the model", "fill"},
      {kValid, "Border value in blocks outside the valid region", "border"},
      {kValid, "Former name of border", "trusted"},
      {0, nullptr, nullptr}};
  static const GType type =
      g_enum_register_static("RaygridUndistortOutside", kValues);
  return type;
}

GType BorderType() {
  static const GEnumValue kValues[] = {
      {RG_BORDER_VALUE, "Black", "black"},
      {RG_BORDER_CLAMP, "Nearest pixel of the calibrated area", "clamp"},
      {0, nullptr, nullptr}};
  static const GType type =
      g_enum_register_static("RaygridUndistortBorder", kValues);
  return type;
}

GType SamplingType() {
  static const GEnumValue kValues[] = {
      {RG_SAMPLING_BILINEAR, "Bilinear interpolation", "bilinear"},
      {RG_SAMPLING_NEAREST, "Nearest pixel", "nearest"},
      {0, nullptr, nullptr}};
  static const GType type =
      g_enum_register_static("RaygridUndistortSampling", kValues);
  return type;
}

enum Property {
  kBlob = 1,
  kTable,
  kEnabled,
  kBorder,
  kOutside,
  kSampling,
  kThreads,
  kCondition
};

}  // namespace

// The C++ members of the element.
struct UndistortState {
  std::mutex mutex;  // guards all members below: any thread may set properties
  raygrid::UndistortSettings settings;
  bool is_changed = false;  // settings changed since `next` was created
  // next: for the current settings; in_use: used until caps are set for next.
  std::shared_ptr<raygrid::FrameUndistorter> next, in_use;
  // The current operating point; NaN: not set.
  double condition = NAN;
  bool is_condition_new = false;
};

struct _RaygridUndistort {
  GstBaseTransform parent;
  UndistortState* state;
};

G_DEFINE_TYPE(RaygridUndistort, raygrid_undistort, GST_TYPE_BASE_TRANSFORM)

namespace {

UndistortState* GetState(gpointer object) {
  return RAYGRID_UNDISTORT(object)->state;
}

struct CapsUnref {
  void operator()(GstCaps* caps) const { gst_caps_unref(caps); }
};
using Caps = std::unique_ptr<GstCaps, CapsUnref>;

Caps GetCaps(GstPad* pad) { return Caps(gst_pad_get_current_caps(pad)); }

void PostError(gpointer element, const raygrid::CameraError& error) {
  GST_ELEMENT_ERROR(element, RESOURCE, SETTINGS, ("%s", error.what()),
                    (nullptr));
}

// Returns the undistorter for the current settings; null while disabled. Throws
// CameraError.
std::shared_ptr<raygrid::FrameUndistorter> CurrentUndistorter(
    UndistortState* state) {
  const std::lock_guard<std::mutex> lock(state->mutex);
  if (state->is_changed) state->next.reset();
  state->is_changed = false;
  if (!state->settings.is_enabled) return nullptr;
  if (state->settings.blob.empty())
    throw raygrid::CameraError(
        raygrid::CameraExit::kUsage,
        "no blob; set blob=camera.raygrid, written by raygrid pack");
  if (!state->next)
    state->next = std::make_shared<raygrid::FrameUndistorter>(state->settings);
  return state->next;
}

// Selects an undistorter, or none to pass frames through. Throws CameraError.
void Use(GstBaseTransform* transform,
         const std::shared_ptr<raygrid::FrameUndistorter>& undistorter,
         const GstCaps* frames, const GstCaps* views) {
  UndistortState* const state = GetState(transform);
  if (undistorter) undistorter->SetCaps(frames, views);
  {
    const std::lock_guard<std::mutex> lock(state->mutex);
    state->in_use = undistorter;
    state->is_condition_new = true;
  }
  gst_base_transform_set_passthrough(transform, !undistorter);
}

// ---- GObject ---------------------------------------------------------------

void SetProperty(GObject* object, guint id, const GValue* value,
                 GParamSpec* spec) {
  UndistortState* const state = GetState(object);
  {
    const std::lock_guard<std::mutex> lock(state->mutex);
    raygrid::UndistortSettings& settings = state->settings;
    switch (id) {
      case kBlob: {
        const char* const path = g_value_get_string(value);
        settings.blob = path ? path : "";
        break;
      }
      case kTable:
        settings.table = g_value_get_int(value);
        break;
      case kEnabled:
        settings.is_enabled = g_value_get_boolean(value) != FALSE;
        break;
      case kBorder:
        settings.border = static_cast<rg_border>(g_value_get_enum(value));
        break;
      case kOutside:
        settings.only_valid = g_value_get_enum(value) == kValid;
        break;
      case kSampling:
        settings.sampling = static_cast<rg_sampling>(g_value_get_enum(value));
        break;
      case kThreads:
        settings.num_threads = g_value_get_uint(value);
        break;
      case kCondition:  // changes per frame, without new caps
        state->condition = g_value_get_double(value);
        state->is_condition_new = true;
        return;
      default:
        G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, spec);
        return;
    }
    state->is_changed = true;
    // With the lock, so that UseSettings() sees both or neither.
    gst_base_transform_reconfigure_src(GST_BASE_TRANSFORM(object));
  }
  gst_base_transform_reconfigure_sink(GST_BASE_TRANSFORM(object));
}

void GetProperty(GObject* object, guint id, GValue* value, GParamSpec* spec) {
  UndistortState* const state = GetState(object);
  const std::lock_guard<std::mutex> lock(state->mutex);
  const raygrid::UndistortSettings& settings = state->settings;
  switch (id) {
    case kBlob:
      g_value_set_string(value, settings.blob.c_str());
      break;
    case kTable:
      g_value_set_int(value, settings.table);
      break;
    case kEnabled:
      g_value_set_boolean(value, settings.is_enabled);
      break;
    case kBorder:
      g_value_set_enum(value, settings.border);
      break;
    case kOutside:
      g_value_set_enum(value, settings.only_valid ? kValid : kFill);
      break;
    case kSampling:
      g_value_set_enum(value, settings.sampling);
      break;
    case kThreads:
      g_value_set_uint(value, settings.num_threads);
      break;
    case kCondition:
      g_value_set_double(value,
                         std::isnan(state->condition) ? 0 : state->condition);
      break;
    default:
      G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, spec);
  }
}

void Finalize(GObject* object) {
  delete GetState(object);
  G_OBJECT_CLASS(raygrid_undistort_parent_class)->finalize(object);
}

// ---- Negotiation -----------------------------------------------------------

gboolean Start(GstBaseTransform* transform) {
  try {
    CurrentUndistorter(GetState(transform));
    return TRUE;
  } catch (const raygrid::CameraError& error) {
    PostError(transform, error);
    return FALSE;
  }
}

gboolean Stop(GstBaseTransform* transform) {
  UndistortState* const state = GetState(transform);
  const std::lock_guard<std::mutex> lock(state->mutex);
  state->next.reset();
  state->in_use.reset();
  return TRUE;
}

GstCaps* TransformCaps(GstBaseTransform* transform, GstPadDirection direction,
                       GstCaps* caps, GstCaps* filter) {
  GstCaps* others;
  try {
    const auto undistorter = CurrentUndistorter(GetState(transform));
    others = undistorter
                 ? raygrid::ConvertCaps(direction, caps, undistorter->tables())
                 : gst_caps_ref(caps);
  } catch (const raygrid::CameraError& error) {
    // Pads can be linked nevertheless; starting, or the next frame, reports the
    // error.
    GST_DEBUG_OBJECT(transform, "%s", error.what());
    others = raygrid::MakeAnySizeCaps(caps);
  }
  if (!filter) return others;
  GstCaps* const filtered =
      gst_caps_intersect_full(filter, others, GST_CAPS_INTERSECT_FIRST);
  gst_caps_unref(others);
  return filtered;
}

gboolean SetCaps(GstBaseTransform* transform, GstCaps* frames, GstCaps* views) {
  try {
    Use(transform, CurrentUndistorter(GetState(transform)), frames, views);
    return TRUE;
  } catch (const raygrid::CameraError& error) {
    PostError(transform, error);
    return FALSE;
  }
}

// The base class reports nothing if no table accepts the caps.
void PostWhyRefused(GstBaseTransform* transform, const GstCaps* frames) {
  try {
    const auto undistorter = CurrentUndistorter(GetState(transform));
    if (undistorter) undistorter->RequireTableFor(frames);
  } catch (const raygrid::CameraError& error) {
    PostError(transform, error);
  }
}

// The pad rejects caps without a table before the element sees the event.
GstPadProbeReturn OnSinkEvent(GstPad*, GstPadProbeInfo* info,
                              gpointer element) {
  GstEvent* const event = gst_pad_probe_info_get_event(info);
  if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {
    GstCaps* frames = nullptr;
    gst_event_parse_caps(event, &frames);
    PostWhyRefused(GST_BASE_TRANSFORM(element), frames);
  }
  return GST_PAD_PROBE_OK;
}

// Renegotiates caps here if settings have changed.
GstFlowReturn SubmitInput(GstBaseTransform* transform, gboolean is_discont,
                          GstBuffer* frame) {
  const GstFlowReturn flow =
      GST_BASE_TRANSFORM_CLASS(raygrid_undistort_parent_class)
          ->submit_input_buffer(transform, is_discont, frame);
  const Caps frames = GetCaps(transform->sinkpad);
  if (flow == GST_FLOW_NOT_NEGOTIATED && frames)
    PostWhyRefused(transform, frames.get());
  return flow;
}

// Applies the current settings if they do not change the caps: the base class
// sets caps only if these change. Throws CameraError.
void UseSettings(GstBaseTransform* transform) {
  UndistortState* const state = GetState(transform);
  {
    // Settings changed after this frame's caps were negotiated may require
    // other caps: they apply to the next frame.
    const std::lock_guard<std::mutex> lock(state->mutex);
    if (state->is_changed || gst_pad_needs_reconfigure(transform->srcpad))
      return;
  }
  const auto undistorter = CurrentUndistorter(state);
  {
    const std::lock_guard<std::mutex> lock(state->mutex);
    if (undistorter == state->in_use) return;
  }
  const Caps frames = GetCaps(transform->sinkpad);
  const Caps views = GetCaps(transform->srcpad);
  if (frames && views) Use(transform, undistorter, frames.get(), views.get());
}

gboolean GetUnitSize(GstBaseTransform*, GstCaps* caps, gsize* size) {
  const auto layout = raygrid::ParseLayout(caps);
  if (!layout) return FALSE;
  *size = layout->num_bytes;
  return TRUE;
}

// Input buffers with padding are larger than their caps imply; output buffers
// are not.
gboolean TransformSize(GstBaseTransform* transform, GstPadDirection, GstCaps*,
                       gsize, GstCaps* others, gsize* size) {
  return GetUnitSize(transform, others, size);
}

// ---- Memory ----------------------------------------------------------------

// The best memory has rows aligned to 64 bytes, and any strides are supported.
// Elements that support GstVideoMeta enable it in the pool, and get such rows;
// others get rows as their caps specify. A pool of Bayer frames would have
// empty buffers, since GstVideoInfo does not support them: upstream elements
// allocate their own.
gboolean ProposeAllocation(GstBaseTransform* transform, GstQuery* decide,
                           GstQuery* query) {
  if (!GST_BASE_TRANSFORM_CLASS(raygrid_undistort_parent_class)
           ->propose_allocation(transform, decide, query))
    return FALSE;
  if (!decide) return TRUE;  // passthrough: downstream proposes
  GstCaps* caps = nullptr;
  GstVideoInfo info;
  gst_query_parse_allocation(query, &caps, nullptr);
  if (!caps || !gst_video_info_from_caps(&info, caps) ||
      GST_VIDEO_INFO_SIZE(&info) == 0)
    return TRUE;
  GstVideoAlignment alignment;
  gst_video_alignment_reset(&alignment);
  for (unsigned& mask : alignment.stride_align) mask = 63;
  GstBufferPool* const pool = gst_video_buffer_pool_new();
  GstStructure* const config = gst_buffer_pool_get_config(pool);
  const guint size = static_cast<guint>(GST_VIDEO_INFO_SIZE(&info));
  gst_buffer_pool_config_set_params(config, caps, size, 0, 0);
  gst_buffer_pool_config_add_option(config,
                                    GST_BUFFER_POOL_OPTION_VIDEO_ALIGNMENT);
  gst_buffer_pool_config_set_video_alignment(config, &alignment);
  if (gst_buffer_pool_set_config(pool, config))
    gst_query_add_allocation_pool(query, pool, size, 0, 0);
  gst_object_unref(pool);
  gst_query_add_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr);
  return TRUE;
}

// ---- Frames ----------------------------------------------------------------

// TransformFrame() transforms regions of interest.
gboolean TransformMeta(GstBaseTransform* transform, GstBuffer* view,
                       GstMeta* meta, GstBuffer* frame) {
  if (meta->info->api == GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE)
    return FALSE;
  return GST_BASE_TRANSFORM_CLASS(raygrid_undistort_parent_class)
      ->transform_meta(transform, view, meta, frame);
}

GstFlowReturn GenerateOutput(GstBaseTransform* transform, GstBuffer** view) {
  try {
    UseSettings(transform);
  } catch (const raygrid::CameraError& error) {
    PostError(transform, error);
    gst_clear_buffer(&transform->queued_buf);
    return GST_FLOW_ERROR;
  }
  return GST_BASE_TRANSFORM_CLASS(raygrid_undistort_parent_class)
      ->generate_output(transform, view);
}

GstFlowReturn TransformFrame(GstBaseTransform* transform, GstBuffer* frame,
                             GstBuffer* view) {
  UndistortState* const state = GetState(transform);
  std::shared_ptr<raygrid::FrameUndistorter> undistorter;
  double condition = NAN;
  {
    const std::lock_guard<std::mutex> lock(state->mutex);
    undistorter = state->in_use;
    if (state->is_condition_new) condition = state->condition;
    state->is_condition_new = false;
  }
  try {
    if (!std::isnan(condition)) undistorter->SetOperatingPoint(condition);
    undistorter->Undistort(frame, view);
    undistorter->MoveRegions(frame, view);
    return GST_FLOW_OK;
  } catch (const raygrid::CameraError& error) {
    PostError(transform, error);
    return GST_FLOW_ERROR;
  }
}

}  // namespace

static void raygrid_undistort_init(RaygridUndistort* self) {
  self->state = new UndistortState;
  GstBaseTransform* const transform = GST_BASE_TRANSFORM(self);
  gst_base_transform_set_qos_enabled(transform, TRUE);
  gst_pad_add_probe(transform->sinkpad, GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM,
                    OnSinkEvent, self, nullptr);
}

static void raygrid_undistort_class_init(RaygridUndistortClass* type) {
  GST_DEBUG_CATEGORY_INIT(undistort_debug, "raygridundistort", 0,
                          "Undistortion with a raygrid blob");
  GObjectClass* const object = G_OBJECT_CLASS(type);
  object->set_property = SetProperty;
  object->get_property = GetProperty;
  object->finalize = Finalize;
  const auto flags = static_cast<GParamFlags>(
      G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING);
  g_object_class_install_property(
      object, kBlob,
      g_param_spec_string(
          "blob", "Blob",
          "Blob with a remap table, written by 'raygrid pack --remap'", "",
          flags));
  g_object_class_install_property(
      object, kTable,
      g_param_spec_int("table", "Table",
                       "Index of the remap table; -1 selects the first that "
                       "matches the frame size",
                       -1, G_MAXINT, -1, flags));
  g_object_class_install_property(
      object, kEnabled,
      g_param_spec_boolean("enabled", "Enabled",
                           "If false, frames pass through unchanged", TRUE,
                           flags));
  g_object_class_install_property(
      object, kBorder,
      g_param_spec_enum("border", "Border",
                        "Value of pixels outside the camera's field of view",
                        BorderType(), RG_BORDER_VALUE, flags));
  g_object_class_install_property(
      object, kOutside,
      g_param_spec_enum(
          "outside", "Outside",
          "Handling of extrapolated pixels, outside the valid region",
          OutsideType(), kFill, flags));
  g_object_class_install_property(
      object, kSampling,
      g_param_spec_enum("sampling", "Sampling", "Interpolation method",
                        SamplingType(), RG_SAMPLING_BILINEAR, flags));
  g_object_class_install_property(
      object, kThreads,
      g_param_spec_uint("threads", "Threads",
                        "Number of threads per frame; 0 uses all processors", 0,
                        256, 1, flags));
  g_object_class_install_property(
      object, kCondition,
      g_param_spec_double("condition", "Operating point",
                          "Lens position (dioptres) or temperature (degrees "
                          "Celsius) of subsequent frames, for a blob "
                          "calibrated over a range; values outside are clamped",
                          -1024, 1024, 0, flags));

  GstElementClass* const element = GST_ELEMENT_CLASS(type);
  gst_element_class_set_static_metadata(
      element, "Lens undistortion with a raygrid blob", "Filter/Effect/Video",
      "Undistorts frames with the remap table of a calibrated camera. Example: "
      "gst-launch-1.0 v4l2src ! video/x-raw,width=640,height=480 ! "
      "raygridundistort blob=camera.raygrid ! autovideosink",
      "raygrid");
  GstCaps* const caps = raygrid::TemplateCaps();
  gst_element_class_add_pad_template(
      element,
      gst_pad_template_new("sink", GST_PAD_SINK, GST_PAD_ALWAYS, caps));
  gst_element_class_add_pad_template(
      element, gst_pad_template_new("src", GST_PAD_SRC, GST_PAD_ALWAYS, caps));
  gst_caps_unref(caps);

  GstBaseTransformClass* const transform = GST_BASE_TRANSFORM_CLASS(type);
  transform->start = Start;
  transform->stop = Stop;
  transform->transform_caps = TransformCaps;
  transform->set_caps = SetCaps;
  transform->submit_input_buffer = SubmitInput;
  transform->generate_output = GenerateOutput;
  transform->get_unit_size = GetUnitSize;
  transform->transform_size = TransformSize;
  transform->propose_allocation = ProposeAllocation;
  transform->transform_meta = TransformMeta;
  transform->transform = TransformFrame;
  transform->passthrough_on_same_caps = FALSE;
  gst_type_mark_as_plugin_api(BorderType(), static_cast<GstPluginAPIFlags>(0));
  gst_type_mark_as_plugin_api(OutsideType(), static_cast<GstPluginAPIFlags>(0));
  gst_type_mark_as_plugin_api(SamplingType(),
                              static_cast<GstPluginAPIFlags>(0));
}
