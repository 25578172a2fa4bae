#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "camera/camera_frame.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/text_encoding.h"
#include "help_formatter.h"
#include "json_output.h"
#include "packing/pack.h"
#include "packing/view_curves.h"
#include "report/contact_sheet.h"
#include "simulation/checkered_room.h"
#include "view_options.h"

namespace raygrid {
namespace {

constexpr uint8_t kNoSourceGrey = 58;  // grey level of pixels without a source
constexpr double kThin = 1.3;          // line width in pixels of the sheet

struct ViewArguments {
  std::vector<std::string> files, images, remaps;
  std::string output = "sheet.png";
  double max_error_px = 0.05;
};

// A camera file and its illustration.
struct ViewedCamera {
  std::string name;  // the file's name
  CameraInput input;
  std::string image;                 // the photograph's path; may be empty
  std::optional<ValidityMask> mask;  // the valid region, if stored
  double square = 0;                 // size of the scene's squares if no
                                     // photograph is given
  Image before;

  const CameraModel& camera() const { return *input.file.camera; }
};

// A blob with a table for each view, or the reason why there is none.
struct ViewTables {
  std::optional<BlobCamera> blob;
  std::vector<VirtualView> views;
  std::vector<uint32_t> indices;  // table indices of the views
  std::string why_none;
};

// Returns the path as typed; of absolute paths, only the file name, so that a
// published sheet does not reveal folders.
std::string GetDisplayName(const std::string& path) {
  const std::filesystem::path typed(path);
  return Printable(typed.is_absolute() ? typed.filename().string() : path);
}

// ---- Photographs and tables ------------------------------------------------

Image ReadPhotograph(const std::string& path, const ImageSize& expected) {
  Image image = ReadImage(path, false);
  if (image.size != expected)
    throw Error(
        ExitCode::kInvalidBlob,
        fmt::format("{}: {} x {} pixels, but the camera is calibrated for {} x "
                    "{}; use an image of the calibrated sensor mode",
                    path, image.size.width, image.size.height, expected.width,
                    expected.height));
  return image;
}

// Returns the requested tables, those of the blob, or the camera's default.
ViewTables MakeViewTables(ViewedCamera* viewed, const ViewArguments& arguments,
                          const CommonOptions& common) {
  ViewTables tables;
  std::optional<BlobCamera>& blob = viewed->input.blob;
  if (blob && blob->has_remap() && arguments.remaps.empty()) {
    tables.indices = blob->ListCalibratedTables();
    for (const uint32_t k : tables.indices)
      tables.views.push_back(blob->GetRemapView(k));
    if (tables.views.empty())
      tables.why_none =
          "all tables are for other sensor modes or inverse remaps";
    tables.blob = std::move(blob);
    return tables;
  }
  PackedCamera packed;
  if (arguments.remaps.empty()) {
    packed = PackSupportedSections(viewed->input.file, common.threads);
  } else {
    PackOptions options;
    for (const std::string& remap : arguments.remaps)
      options.remaps.push_back(
          MakeView(viewed->camera(), ParseView("--remap", remap)));
    options.max_error_px = arguments.max_error_px;
    options.num_threads = common.threads;
    packed = PackCamera(viewed->input.file, options);
  }
  for (const PackedRemap& remap : packed.remaps) {
    tables.indices.push_back(static_cast<uint32_t>(tables.indices.size()));
    tables.views.push_back(remap.view);
  }
  if (!tables.views.empty()) tables.blob.emplace("packed camera", packed.blob);
  for (const std::string& warning : packed.warnings)
    tables.why_none += (tables.why_none.empty() ? "" : "; ") + warning;
  return tables;
}

// ---- Tiles -----------------------------------------------------------------

std::vector<std::string> ViewCaption(const VirtualView& view) {
  std::vector<std::string> lines = {
      fmt::format(
          "{} x {} px, {}, field of view {:.1f}° x {:.1f}°", view.size.width,
          view.size.height, ProjectionName(view.projection),
          view.HorizontalFieldOfViewDeg(), view.VerticalFieldOfViewDeg()),
      fmt::format("K: fx {:.6g}, fy {:.6g}, cx {:.6g}, cy {:.6g}",
                  view.focal_px.x(), view.focal_px.y(), view.center_px.x(),
                  view.center_px.y())};
  if (view.IsTurned()) {
    const Eigen::Vector3d angles = ViewAnglesDeg(view.camera_from_view);
    lines.push_back(
        fmt::format("rotated {:.4g}° right, {:.4g}° up, {:.4g}° clockwise",
                    angles[0], angles[1], angles[2]));
  } else {
    lines.push_back("not rotated");
  }
  return lines;
}

double ValidFraction(const ValidityMask& mask, const CameraModel& camera) {
  CameraUncertainty uncertainty;
  uncertainty.mask = mask;
  return uncertainty.ValidFraction(camera.image_size(), camera.area());
}

// Returns the outlines of the calibrated area and of the valid region in the
// camera's image. If the area is the whole image and a valid region is stored,
// only the latter is outlined.
std::vector<SheetCurves> KnownCurves(const ViewedCamera& viewed) {
  const CameraModel& camera = viewed.camera();
  std::vector<SheetCurves> known;
  const Area &area = camera.area(), image = WholeImage(camera.image_size());
  const bool is_whole = area.Contains({image.x0, image.y0}) &&
                        area.Contains({image.x1, image.y1});
  if (!viewed.mask || !is_whole) {
    known.emplace_back();
    known.back().curves = ComputeAreaOutline(area);
    known.back().color = kAreaColor;
  }
  if (viewed.mask) {
    known.emplace_back();
    known.back().curves =
        ComputeValidOutline(*viewed.mask, camera.image_size());
    known.back().color = kValidColor;
  }
  return known;
}

SheetTile TileBefore(const ViewedCamera& viewed,
                     const std::vector<VirtualView>& views) {
  const CameraModel& camera = viewed.camera();
  SheetTile tile;
  tile.title = viewed.name + ": before";
  const CameraFile& file = viewed.input.file;
  tile.caption = {
      fmt::format("{} x {} px, {}, field of view {:.1f}° x {:.1f}°{}",
                  camera.image_size().width, camera.image_size().height,
                  camera.Name(), ComputeVisibleAngleDeg(camera, 0),
                  ComputeVisibleAngleDeg(camera, 1),
                  file.name.empty() ? "" : ", " + Printable(file.name)),
      viewed.mask ? fmt::format("valid region: {:.0f} % of the image",
                                100 * ValidFraction(*viewed.mask, camera))
                  : "no valid region in the file",
      viewed.image.empty() ? "a rendered checkered room, seen by this camera"
                           : GetDisplayName(viewed.image)};
  tile.picture = viewed.before;
  for (size_t k = 0; k < views.size(); ++k) {
    SheetCurves edge;
    edge.curves = ComputeViewEdge(camera, views[k]);
    edge.color = GetViewColor(k);
    edge.is_dashed = true;
    tile.curves.push_back(std::move(edge));
  }
  for (SheetCurves& known : KnownCurves(viewed))
    tile.curves.push_back(std::move(known));
  return tile;
}

// Returns the straight lines of the scene, or of a room around the view.
SheetCurves StraightCurves(const ViewedCamera& viewed,
                           const VirtualView& view) {
  SheetCurves drawn;
  drawn.color = kStraightColor;
  drawn.width = kThin;
  drawn.curves =
      viewed.image.empty()
          ? MakeRoomLines(view, Eigen::Matrix3d::Identity(), viewed.square)
          : MakeRoomLines(view, view.camera_from_view,
                          ComputeViewSquareSize(view));
  return drawn;
}

SheetTile MakeViewTile(const ViewedCamera& viewed, const ViewTables& tables,
                       size_t k) {
  const VirtualView& view = tables.views[k];
  SheetTile tile;
  tile.title = fmt::format("{}: view {}", viewed.name, tables.indices[k]);
  tile.caption = ViewCaption(view);
  tile.picture =
      tables.blob->Undistort(viewed.before, kNoSourceGrey, tables.indices[k]);
  tile.curves = {StraightCurves(viewed, view)};
  for (SheetCurves& known : KnownCurves(viewed)) {
    known.curves = ProjectCurves(viewed.camera(), view, known.curves);
    tile.curves.push_back(std::move(known));
  }
  tile.frame = GetViewColor(k);
  return tile;
}

// A camera's row of the sheet, and its captions as JSON.
struct ViewedRow {
  SheetRow row;
  nlohmann::ordered_json json;
};

// The file of a view has no image before undistortion: only the view is shown.
ViewedRow MakeViewRow(const VirtualView& view, ViewedCamera viewed,
                      const CommonOptions& common) {
  SheetTile tile;
  viewed.square = ComputeViewSquareSize(view);
  tile.picture =
      viewed.image.empty()
          ? RenderCheckeredRoom(*MakeRotatedViewCamera(view), viewed.square,
                                kNoSourceGrey, common.threads)
          : ReadPhotograph(viewed.image, view.size);
  tile.title = viewed.name + ": a view";
  tile.caption = ViewCaption(view);
  tile.caption.push_back(viewed.image.empty()
                             ? "a rendered checkered room, in this view"
                             : GetDisplayName(viewed.image));
  tile.curves = {StraightCurves(viewed, view)};
  return {{{std::move(tile)}},
          {{"views", nlohmann::ordered_json::array({MakeViewJson(view)})}}};
}

ViewedRow MakeCameraRow(ViewedCamera viewed, const ViewArguments& arguments,
                        const CommonOptions& common) {
  if (!viewed.input.blob) AlignToCanonicalFrame(&viewed.input.file.camera);
  viewed.mask = LoadValidityMask(viewed.input);
  viewed.square = ComputeSceneSquareSize(viewed.camera());
  viewed.before =
      viewed.image.empty()
          ? RenderCheckeredRoom(viewed.camera(), viewed.square, kNoSourceGrey,
                                common.threads)
          : ReadPhotograph(viewed.image, viewed.camera().image_size());
  const ViewTables tables = MakeViewTables(&viewed, arguments, common);
  ViewedRow result;
  result.row.tiles.push_back(TileBefore(viewed, tables.views));
  for (size_t k = 0; k < tables.views.size(); ++k)
    result.row.tiles.push_back(MakeViewTile(viewed, tables, k));
  if (tables.views.empty()) {
    SheetTile tile;
    tile.title = viewed.name + ": no view";
    tile.message = "No view: " + tables.why_none;
    result.row.tiles.push_back(std::move(tile));
    result.json["view_error"] = tables.why_none;
  }
  if (viewed.mask)
    result.json["valid_fraction"] =
        ValidFraction(*viewed.mask, viewed.camera());
  result.json["views"] = nlohmann::json::array();
  for (const VirtualView& view : tables.views)
    result.json["views"].push_back(MakeViewJson(view));
  return result;
}

ViewedRow MakeFileRow(const std::string& path, const std::string& image,
                      const ViewArguments& arguments,
                      const CommonOptions& common) {
  ViewedCamera viewed;
  viewed.name = GetDisplayName(path);
  viewed.image = image;
  viewed.input = ReadCamera(path, common.at);
  if (!common.quiet) WarnAboutFailedCalibration(path, viewed.input.file);
  auto view = MakeCameraView(viewed.camera());
  const auto& pose = viewed.input.file.camera_from_view;
  if (!view || viewed.input.blob || !arguments.remaps.empty())
    return MakeCameraRow(std::move(viewed), arguments, common);
  if (pose) view->camera_from_view = pose->rotation.toRotationMatrix();
  return MakeViewRow(*view, std::move(viewed), common);
}

// ---- The command -----------------------------------------------------------

// Returns the marks that occur in a sheet, and their meanings.
std::vector<SheetMark> ListMarks(const std::vector<SheetRow>& rows) {
  const SheetMark all[] = {
      {kValidColor, false, "valid region"},
      {kAreaColor, false, "calibrated area"},
      {kStraightColor, false, "straight line in the world"},
      {GetViewColor(0), true,
       "boundary of a view, in the colour of its frame"}};
  std::vector<SheetMark> marks;
  for (const SheetMark& mark : all) {
    bool is_used = false;
    for (const SheetRow& row : rows)
      for (const SheetTile& tile : row.tiles)
        for (const SheetCurves& curves : tile.curves)
          is_used |= curves.color == mark.color && !curves.curves.empty();
    if (is_used) marks.push_back(mark);
  }
  marks.push_back({kEmptyColor, false, "not calibrated or not visible"});
  return marks;
}

void RequireImageForEach(const ViewArguments& arguments) {
  const size_t images = arguments.images.size();
  if (images > 1 && images != arguments.files.size())
    throw Error(ExitCode::kUsage,
                fmt::format("{} images for {} files; specify one --image for "
                            "all files, or one per file",
                            images, arguments.files.size()));
}

void Run(const ViewArguments& arguments, const CommonOptions& common) {
  RequireImageForEach(arguments);
  for (const std::string& remap : arguments.remaps) ParseView("--remap", remap);
  std::vector<std::string> inputs = arguments.files;
  inputs.insert(inputs.end(), arguments.images.begin(), arguments.images.end());
  RequireNoInputReplaced(inputs, {arguments.output});
  std::vector<SheetRow> rows;
  auto files = nlohmann::ordered_json::array();
  for (size_t k = 0; k < arguments.files.size(); ++k) {
    std::string image;
    if (!arguments.images.empty())
      image = arguments.images[arguments.images.size() == 1 ? 0 : k];
    ViewedRow row = MakeFileRow(arguments.files[k], image, arguments, common);
    nlohmann::ordered_json entry = {{"file", arguments.files[k]}};
    if (!image.empty()) entry["image"] = image;
    entry.update(row.json);
    files.push_back(std::move(entry));
    rows.push_back(std::move(row.row));
  }
  const Image sheet = ContactSheet(rows, ListMarks(rows));
  WriteFile(arguments.output, EncodePng(sheet));
  if (common.json) {
    const nlohmann::ordered_json result = {
        {"file", arguments.output},
        {"size", {sheet.size.width, sheet.size.height}},
        {"files", files}};
    PrintCommandJson(result);
  } else if (!common.quiet) {
    fmt::print("{}: {} x {} px, {} file{}\n", arguments.output,
               sheet.size.width, sheet.size.height, rows.size(),
               rows.size() == 1 ? "" : "s");
  }
}

}  // namespace

void AddView(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "view",
      "Show original and undistorted images side by side on a contact sheet.",
      "raygrid view front.raygrid --image photo.png -o sheet.png", common);
  command->footer(kViewSyntaxHelp + ("\n" + command->get_footer()));
  auto arguments = std::make_shared<ViewArguments>();
  command
      ->add_option("files", arguments->files,
                   "cameras to compare, each drawn as one row: blobs, "
                   "camera.yaml or NAME.camera.yaml")
      ->required();
  command
      ->add_option(
          "--image", arguments->images,
          "image for all rows, or one per row (default: a rendered room)")
      ->option_text("FILE")
      ->allow_extra_args(false);
  BeginGroup(command, help_group::kView);
  AddAtOption(command, common);
  command
      ->add_option("--remap", arguments->remaps,
                   "use this output view instead of the one stored in the "
                   "blob; repeatable")
      ->option_text("WxH[,KEY=VALUE...]")
      ->allow_extra_args(false);
  command
      ->add_option("--max-error-px", arguments->max_error_px,
                   "maximum error allowed for the tables built for --remap")
      ->option_text("PX")
      ->check(AboveZero())
      ->capture_default_str();
  BeginGroup(command, help_group::kOutput);
  command->add_option("-o,--output", arguments->output, "PNG file to write")
      ->option_text("FILE")
      ->capture_default_str();
  AddHugeOption(command);
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
