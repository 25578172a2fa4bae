#include "bag_input.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include "bags/camera_info.h"
#include "bags/image_message.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/file_parts.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"
#include "help_formatter.h"
#include "progress_bar.h"

namespace raygrid {
namespace {

// The bags of a command, each of which is read once.
class BagReader {
 public:
  explicit BagReader(bool quiet) : quiet_(quiet) {}

  const BagIndex& Read(const std::string& path) {
    const auto found = bags_.find(path);
    if (found != bags_.end()) return found->second;
    ProgressBar bar(quiet_);
    BagIndex index = IndexBag(
        path, [&](double done) { bar.Show("reading " + path, 0.1 * done); });
    Print(index.bag->remarks());
    return bags_.emplace(path, std::move(index)).first->second;
  }
  void Print(const std::vector<std::string>& remarks) const {
    if (quiet_) return;
    for (const std::string& remark : remarks)
      fmt::print(stderr, "raygrid: {}\n", Printable(remark));
  }

 private:
  bool quiet_;
  std::map<std::string, BagIndex> bags_;
};

// Makes images of a topic readable as files with these names. Returns their
// paths.
std::vector<std::string> AddParts(const BagIndex& index,
                                  const ImageTopic& topic,
                                  const std::vector<BagImage>& images,
                                  const std::vector<std::string>& names) {
  // Without a slash at its end, the folder of a path is this.
  std::string folder = index.bag->path() + ":" + topic.topic.name;
  while (folder.back() == '/') folder.pop_back();
  auto places = std::make_shared<std::map<std::string, MessagePlace>>();
  std::vector<std::string> paths;
  for (size_t k = 0; k < images.size(); ++k) {
    paths.push_back(folder + "/" + names[k]);
    places->emplace(paths.back(), images[k].place);
  }
  FileParts parts;
  parts.files = index.bag->files();
  parts.read = [bag = index.bag, topic = topic.topic,
                places](const std::string& path) {
    const std::string data = bag->Read(places->at(path));
    try {
      ImageMessage message;
      ParseImageMessage(topic, data, &message);
      return MakeImageFile(message);
    } catch (const InputError& error) {
      throw InputError(path + ": " + error.what());
    }
  };
  AddFileParts(paths, std::move(parts));
  return paths;
}

BagFrame MakeFrame(const ImageTopic& topic, const BagImage& image) {
  return {topic.topic.name, topic.frame_id, topic.encoding, image.stamp_ns,
          image.log_ns};
}

std::vector<std::string> NamesOf(const std::vector<BagImage>& images) {
  std::vector<std::string> names;
  for (const BagImage& image : images)
    names.push_back(FormatStamp(image.stamp_ns));
  return names;
}

void RequireBagOptionsUsed(const BagOptions& options) {
  const BagOptions none;
  const char* const unused =
      !options.topic.empty()                              ? "--topic"
      : options.selection.every != none.selection.every   ? "--every"
      : options.selection.from_s != none.selection.from_s ? "--from-s"
      : options.selection.to_s != none.selection.to_s     ? "--to-s"
      : options.selection.by_log_time                     ? "--stamps"
      : options.tolerance_s != none.tolerance_s           ? "--sync-tolerance-s"
                                                          : nullptr;
  if (unused)
    throw Error(
        ExitCode::kUsage,
        fmt::format("{} selects images of a bag, but no bag is given", unused));
}

const ImageTopic& FindSelected(const BagIndex& index,
                               const BagArgument& argument,
                               const BagOptions& options) {
  return index.Find(argument.topic.empty() ? options.topic : argument.topic);
}

// Keeps one of every n frames, which cameras share.
void KeepEvery(int every, std::vector<SelectedImages>* images,
               std::vector<std::vector<std::string>>* names) {
  std::set<std::string> all;
  for (const auto& own : *names) all.insert(own.begin(), own.end());
  std::set<std::string> kept;
  int count = 0;
  for (const std::string& name : all)
    if (count++ % every == 0) kept.insert(name);
  for (size_t c = 0; c < names->size(); ++c) {
    std::vector<BagImage> own_images;
    std::vector<std::string> own_names;
    for (size_t k = 0; k < (*names)[c].size(); ++k) {
      if (kept.count((*names)[c][k]) == 0) continue;
      own_names.push_back((*names)[c][k]);
      own_images.push_back((*images)[c].images[k]);
    }
    (*names)[c] = std::move(own_names);
    (*images)[c].images = std::move(own_images);
  }
}

// Throws if two cameras of a rig have the same topic.
void RequireDifferentTopics(const std::vector<NamedValue>& cameras,
                            const std::vector<const ImageTopic*>& topics) {
  for (size_t c = 0; c < topics.size(); ++c)
    for (size_t before = 0; before < c; ++before)
      if (topics[c] == topics[before])
        throw Error(ExitCode::kUsage,
                    fmt::format("--camera {}={}: same topic as camera {}",
                                cameras[c].name, cameras[c].value,
                                cameras[before].name));
}

}  // namespace

void AddBagOptions(CLI::App* command, BagOptions* options, bool accepts_rigs) {
  BeginGroup(command, help_group::kBags);
  command
      ->add_option("--topic", options->topic,
                   "topic of the images, if a bag has several")
      ->option_text("TOPIC");
  command
      ->add_option("--every", options->selection.every,
                   "use one of every N images")
      ->option_text("N")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command
      ->add_option("--from-s", options->selection.from_s,
                   "first image, in seconds from the start of the bag")
      ->option_text("S");
  command
      ->add_option("--to-s", options->selection.to_s,
                   "last image, in seconds from the start of the bag")
      ->option_text("S");
  command
      ->add_option_function<std::string>(
          "--stamps",
          [options](const std::string& word) {
            options->selection.by_log_time = word == "log";
          },
          "names and times of images: stamps of their headers, or when they "
          "were recorded")
      ->check(CLI::IsMember({"header", "log"}))
      ->option_text("header|log")
      ->default_str("header");
  if (!accepts_rigs) return;
  command
      ->add_option("--sync-tolerance-s", options->tolerance_s,
                   "largest difference of the stamps of a rig's frame")
      ->option_text("S")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
}

std::optional<BagArgument> ParseBagArgument(const std::string& text) {
  std::error_code error;
  if (std::filesystem::exists(text, error))
    return Bag::Recognizes(text) ? std::optional(BagArgument{text, ""})
                                 : std::nullopt;
  for (size_t at = text.find(':'); at != std::string::npos;
       at = text.find(':', at + 1))
    if (Bag::Recognizes(text.substr(0, at)))
      return BagArgument{text.substr(0, at), text.substr(at + 1)};
  return std::nullopt;
}

std::vector<std::string> ExpandBags(const std::vector<std::string>& images,
                                    const BagOptions& options, bool quiet,
                                    BagFrames* frames) {
  std::vector<std::string> paths;
  BagReader reader(quiet);
  bool has_bags = false;
  for (const std::string& image : images) {
    const auto argument = ParseBagArgument(image);
    if (!argument) {
      paths.push_back(image);
      continue;
    }
    const BagIndex& index = reader.Read(argument->bag);
    const ImageTopic& topic = FindSelected(index, *argument, options);
    const SelectedImages selected =
        SelectImages(index, topic, options.selection);
    reader.Print(selected.remarks);
    has_bags = true;
    const std::vector<std::string> added =
        AddParts(index, topic, selected.images, NamesOf(selected.images));
    paths.insert(paths.end(), added.begin(), added.end());
    for (size_t k = 0; frames && k < added.size(); ++k)
      frames->emplace(added[k], MakeFrame(topic, selected.images[k]));
  }
  if (!has_bags) RequireBagOptionsUsed(options);
  return paths;
}

ImageTimes MakeImageTimes(const BagFrames& frames) {
  int64_t origin_ns = INT64_MAX;
  for (const auto& [path, frame] : frames)
    origin_ns = std::min(origin_ns, frame.stamp_ns);
  ImageTimes times;
  for (const auto& [path, frame] : frames)
    times[std::filesystem::path(path).filename().string()] =
        1e-9 * static_cast<double>(frame.stamp_ns - origin_ns);
  return times;
}

std::vector<RigCameraImages> ExpandRigBags(
    const std::vector<NamedValue>& cameras, const BagOptions& options,
    const std::string& sync_by, bool quiet, std::vector<ImageTimes>* times) {
  std::vector<RigCameraImages> expanded;
  std::vector<BagArgument> arguments;
  for (const auto& [name, value] : cameras) {
    expanded.push_back({name, {value}});
    if (const auto argument = ParseBagArgument(value))
      arguments.push_back(*argument);
  }
  if (arguments.empty()) {
    RequireBagOptionsUsed(options);
    return {};
  }
  if (arguments.size() < cameras.size())
    throw Error(ExitCode::kUsage,
                "--camera: specify either folders or bags for all cameras");
  if (sync_by != "name")
    throw Error(ExitCode::kUsage,
                fmt::format("--sync-by {}: frames of bags are matched by their "
                            "stamps; omit the option",
                            sync_by));
  BagReader reader(quiet);
  std::vector<const BagIndex*> bags;
  std::vector<const ImageTopic*> topics;
  std::vector<SelectedImages> images;
  ImageSelection selection = options.selection;
  selection.every = 1;
  std::vector<std::string> names;
  for (size_t c = 0; c < cameras.size(); ++c) {
    names.push_back(cameras[c].name);
    bags.push_back(&reader.Read(arguments[c].bag));
    topics.push_back(&FindSelected(*bags[c], arguments[c], options));
    images.push_back(SelectImages(*bags[c], *topics[c], selection));
    reader.Print(images.back().remarks);
  }
  RequireDifferentTopics(cameras, topics);
  PairedImages paired = PairImages(names, images, options.tolerance_s);
  reader.Print(paired.remarks);
  KeepEvery(options.selection.every, &images, &paired.names);
  for (size_t c = 0; c < cameras.size(); ++c) {
    expanded[c].images =
        AddParts(*bags[c], *topics[c], images[c].images, paired.names[c]);
    BagFrames frames;
    for (size_t k = 0; k < images[c].images.size(); ++k)
      frames.emplace(expanded[c].images[k],
                     MakeFrame(*topics[c], images[c].images[k]));
    if (times) times->push_back(MakeImageTimes(frames));
  }
  return expanded;
}

bool IsBagOutput(const std::string& path) {
  return std::filesystem::path(path).extension() == ".mcap";
}

std::string ReadCameraBytes(const std::string& path) {
  const auto argument = ParseBagArgument(path);
  if (!argument) return ReadFile(path);
  std::vector<std::string> remarks;
  const std::string text = FormatCameraInfo(
      ReadCameraInfo(argument->bag, argument->topic, &remarks));
  for (const std::string& remark : remarks)
    fmt::print(stderr, "raygrid: {}\n", Printable(remark));
  // The bag is an input, which no output may replace. A command may read the
  // camera twice.
  if (!argument->topic.empty() &&
      FilesOf(path) == std::vector<std::string>{path})
    AddFileParts({path}, {[text](const std::string&) { return text; },
                          Bag(argument->bag).files()});
  return text;
}

}  // namespace raygrid
