#include "bags/image_topics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "bags/image_message.h"
#include "bags/topic_choice.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr double kNanosecond = 1e-9;

double Seconds(int64_t ns) { return static_cast<double>(ns) * kNanosecond; }

void AddImage(const BagTopic& topic, const BagMessage& message,
              ImageTopic* images) {
  ImageMessage image;
  try {
    ParseImageMessage(topic, message.data, &image);
    if (images->images.empty()) {
      images->frame_id = image.frame_id;
      images->encoding = image.encoding;
    }
    images->images.push_back(
        {image.stamp_ns, message.log_ns, image.size, message.place});
  } catch (const InputError& error) {
    if (images->num_undecoded++ == 0)
      images->first_failure = fmt::format(
          "recorded at {}: {}", FormatStamp(message.log_ns), error.what());
  }
}

// ---- Stamps

double MedianInterval(const std::vector<BagImage>& images) {
  std::vector<double> intervals;
  for (size_t k = 1; k < images.size(); ++k)
    intervals.push_back(Seconds(images[k].stamp_ns - images[k - 1].stamp_ns));
  if (intervals.empty()) return 0;
  const auto middle = intervals.begin() + intervals.size() / 2;
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

// Remarks on stamps in the order of the bag.
void RemarkOrder(const std::vector<BagImage>& images, const std::string& where,
                 std::vector<std::string>* remarks) {
  constexpr double kMinJumpS = 0.5;
  size_t num_backwards = 0;
  for (size_t k = 1; k < images.size(); ++k) {
    const int64_t step_ns = images[k].stamp_ns - images[k - 1].stamp_ns;
    if (step_ns < 0 && num_backwards++ == 0)
      remarks->push_back(fmt::format(
          "{}: stamps run backwards, first at {}; images are sorted by stamp",
          where, FormatStamp(images[k].stamp_ns)));
    const double jump_s =
        Seconds(step_ns) - Seconds(images[k].log_ns - images[k - 1].log_ns);
    if (std::abs(jump_s) < kMinJumpS) continue;
    remarks->push_back(fmt::format(
        "{}: the clock of the stamps jumps by {:.3g} s at {}; select a range "
        "without the jump, or use --stamps log",
        where, jump_s, FormatStamp(images[k].stamp_ns)));
    return;
  }
}

// Remarks on gaps between sorted images.
void RemarkGaps(const std::vector<BagImage>& images, const std::string& where,
                std::vector<std::string>* remarks) {
  constexpr size_t kMinImages = 10;
  if (images.size() < kMinImages) return;
  const double interval_s = MedianInterval(images);
  size_t num_gaps = 0, longest = 0;
  double longest_s = 0;
  for (size_t k = 1; k < images.size(); ++k) {
    const double gap_s = Seconds(images[k].stamp_ns - images[k - 1].stamp_ns);
    if (gap_s < 1.5 * interval_s) continue;
    ++num_gaps;
    if (gap_s > longest_s) {
      longest_s = gap_s;
      longest = k - 1;
    }
  }
  if (num_gaps > 0)
    remarks->push_back(fmt::format(
        "{}: {} drop-out{} (images every {:.3g} s), the longest of {:.3g} s "
        "after {}",
        where, num_gaps, num_gaps == 1 ? "" : "s", interval_s, longest_s,
        FormatStamp(images[longest].stamp_ns)));
}

// Uses log times for images without stamps.
void CompleteStamps(bool by_log_time, const std::string& where,
                    std::vector<BagImage>* images,
                    std::vector<std::string>* remarks) {
  size_t num_without = 0;
  for (BagImage& image : *images) {
    if (!by_log_time && image.stamp_ns > 0) continue;
    if (!by_log_time) ++num_without;
    image.stamp_ns = std::max<int64_t>(image.log_ns, 0);
  }
  if (num_without > 0)
    remarks->push_back(
        fmt::format("{}: {} images have no stamp; the time of their recording "
                    "is used",
                    where, num_without));
}

// Sorts by stamp, and keeps the first of images with the same stamp.
void SortImages(const std::string& where, std::vector<BagImage>* images,
                std::vector<std::string>* remarks) {
  std::stable_sort(images->begin(), images->end(),
                   [](const BagImage& a, const BagImage& b) {
                     return a.stamp_ns < b.stamp_ns;
                   });
  const auto end = std::unique(images->begin(), images->end(),
                               [](const BagImage& a, const BagImage& b) {
                                 return a.stamp_ns == b.stamp_ns;
                               });
  if (end == images->end()) return;
  remarks->push_back(
      fmt::format("{}: {} images with the stamp of another one were skipped",
                  where, images->end() - end));
  images->erase(end, images->end());
}

void RequireOneSize(const std::string& where,
                    const std::vector<BagImage>& images) {
  const ImageSize& first = images.front().size;
  for (const BagImage& image : images)
    if (image.size != first)
      throw InputError(fmt::format(
          "{}: the image size changes from {} x {} to {} x {} pixels at {}; "
          "select images of one size with --from-s and --to-s",
          where, first.width, first.height, image.size.width, image.size.height,
          FormatStamp(image.stamp_ns)));
}

// ---- Rigs

using Indices = std::vector<size_t>;

// Returns for each image of a camera the nearest one of another camera. Of two
// equally near ones, the earlier or the later one.
Indices FindNearest(const std::vector<BagImage>& from, const Indices& of_from,
                    const std::vector<BagImage>& to, const Indices& of_to,
                    bool prefers_later) {
  Indices nearest;
  size_t at = 0;
  for (const size_t k : of_from) {
    const auto distance = [&](size_t other) {
      return std::abs(to[of_to[other]].stamp_ns - from[k].stamp_ns);
    };
    while (at + 1 < of_to.size() &&
           (distance(at + 1) < distance(at) ||
            (prefers_later && distance(at + 1) == distance(at))))
      ++at;
    nearest.push_back(at);
  }
  return nearest;
}

// The images of a camera, and the reference images of their frames.
struct FrameImages {
  const std::vector<BagImage>* images = nullptr;
  std::vector<const BagImage*> references;  // null: none yet

  explicit FrameImages(const std::vector<BagImage>& own)
      : images(&own), references(own.size()) {}
  Indices WithoutFrame() const {
    Indices indices;
    for (size_t k = 0; k < references.size(); ++k)
      if (!references[k]) indices.push_back(k);
    return indices;
  }
};

// Adds images of a camera to frames of reference images: those which are
// mutually nearest. Marks the frames that receive one.
void AddToFrames(const FrameImages& reference, const Indices& frames,
                 int64_t tolerance_ns, FrameImages* camera,
                 std::vector<bool>* is_shared, int64_t* largest_ns) {
  const std::vector<BagImage>&first = *reference.images, &own = *camera->images;
  const Indices left = camera->WithoutFrame();
  if (left.empty()) return;
  // Of equal distances, both prefer the image before the reference.
  const Indices to_own = FindNearest(first, frames, own, left, false),
                to_first = FindNearest(own, left, first, frames, true);
  for (size_t k = 0; k < frames.size(); ++k) {
    const BagImage &at = first[frames[k]], &near = own[left[to_own[k]]];
    const int64_t distance_ns = std::abs(near.stamp_ns - at.stamp_ns);
    if (to_first[to_own[k]] != k || distance_ns > tolerance_ns) continue;
    camera->references[left[to_own[k]]] = &at;
    (*is_shared)[k] = true;
    *largest_ns = std::max(*largest_ns, distance_ns);
  }
}

// Remarks if frames could consist of images of different exposures.
void RemarkTolerance(const std::vector<SelectedImages>& images,
                     double tolerance_s, std::vector<std::string>* remarks) {
  double interval_s = INFINITY;
  for (const SelectedImages& own : images)
    if (own.images.size() > 1)
      interval_s = std::min(interval_s, MedianInterval(own.images));
  if (images.size() > 1 && tolerance_s > interval_s / 2)
    remarks->push_back(fmt::format(
        "--sync-tolerance-s {:g} exceeds half the interval between images "
        "({:.3g} s): images of different exposures may be paired; use less",
        tolerance_s, interval_s));
}

// The median difference of a camera's stamps and log times.
double ComputeClockOffset(const std::vector<BagImage>& images) {
  std::vector<double> offsets;
  for (const BagImage& image : images)
    offsets.push_back(Seconds(image.stamp_ns - image.log_ns));
  const auto middle = offsets.begin() + offsets.size() / 2;
  std::nth_element(offsets.begin(), middle, offsets.end());
  return *middle;
}

}  // namespace

const ImageTopic& BagIndex::Find(const std::string& name) const {
  std::vector<std::string> names;
  for (const ImageTopic& topic : topics) names.push_back(topic.topic.name);
  return topics[ChooseTopic(*bag, names, name,
                            "images (sensor_msgs or Foxglove)")];
}

BagIndex IndexBag(const std::string& path,
                  const std::function<void(double)>& progress) {
  BagIndex index;
  index.bag = std::make_shared<Bag>(path);
  std::map<size_t, ImageTopic> by_topic;
  bool is_first = true;
  index.bag->Scan(
      [&](const BagMessage& message) {
        index.start_ns = is_first ? message.log_ns
                                  : std::min(index.start_ns, message.log_ns);
        is_first = false;
        const BagTopic& topic = index.bag->topics()[message.topic];
        if (HasImages(topic))
          AddImage(topic, message, &by_topic[message.topic]);
      },
      progress);
  for (auto& [topic, images] : by_topic) {
    images.topic = index.bag->topics()[topic];
    index.topics.push_back(std::move(images));
  }
  return index;
}

SelectedImages SelectImages(const BagIndex& index, const ImageTopic& topic,
                            const ImageSelection& selection) {
  const std::string where = index.bag->path() + ":" + topic.topic.name;
  SelectedImages selected;
  std::vector<BagImage>& images = selected.images;
  if (topic.num_undecoded > 0)
    selected.remarks.push_back(fmt::format(
        "{}: {} of {} messages do not decode and were skipped, the first {}",
        where, topic.num_undecoded, topic.topic.num_messages,
        topic.first_failure));
  for (const BagImage& image : topic.images) {
    const double at_s = Seconds(image.log_ns - index.start_ns);
    if (at_s >= selection.from_s && at_s <= selection.to_s)
      images.push_back(image);
  }
  if (images.empty())
    throw InputError(
        topic.images.empty()
            ? fmt::format("{}: no message decodes; the first was {}", where,
                          topic.first_failure)
            : fmt::format(
                  "{}: no images from {:g} to {:g} s; the bag has them from "
                  "{:.3f} to {:.3f} s",
                  where, selection.from_s, selection.to_s,
                  Seconds(topic.topic.first_ns - index.start_ns),
                  Seconds(topic.topic.last_ns - index.start_ns)));
  CompleteStamps(selection.by_log_time, where, &images, &selected.remarks);
  RequireOneSize(where, images);
  RemarkOrder(images, where, &selected.remarks);
  SortImages(where, &images, &selected.remarks);
  RemarkGaps(images, where, &selected.remarks);
  std::vector<BagImage> kept;
  for (size_t k = 0; k < images.size(); k += selection.every)
    kept.push_back(images[k]);
  images = std::move(kept);
  return selected;
}

std::string FormatStamp(int64_t stamp_ns) {
  constexpr int64_t kSecond = 1000000000;
  return fmt::format("{:010}.{:09}", stamp_ns / kSecond, stamp_ns % kSecond);
}

PairedImages PairImages(const std::vector<std::string>& cameras,
                        const std::vector<SelectedImages>& images,
                        double tolerance_s) {
  const size_t num_cameras = images.size();
  const auto tolerance_ns = std::llround(tolerance_s / kNanosecond);
  PairedImages paired;
  paired.names.resize(num_cameras);
  std::vector<size_t> num_alone(num_cameras);
  std::vector<FrameImages> frames;
  for (const SelectedImages& own : images) frames.emplace_back(own.images);
  size_t num_frames = 0;
  int64_t largest_ns = 0;
  for (size_t r = 0; r < num_cameras; ++r) {
    const Indices begun = frames[r].WithoutFrame();
    std::vector<bool> is_shared(begun.size());
    for (size_t c = r + 1; !begun.empty() && c < num_cameras; ++c)
      AddToFrames(frames[r], begun, tolerance_ns, &frames[c], &is_shared,
                  &largest_ns);
    for (const size_t k : begun) frames[r].references[k] = &images[r].images[k];
    num_alone[r] = std::count(is_shared.begin(), is_shared.end(), false);
    num_frames += begun.size() - num_alone[r];
    for (const BagImage* reference : frames[r].references)
      paired.names[r].push_back(FormatStamp(reference->stamp_ns));
  }
  for (size_t c = 0; c < num_cameras; ++c) {
    const double offset_s = ComputeClockOffset(images[c].images) -
                            ComputeClockOffset(images[0].images);
    if (num_cameras == 1 || num_alone[c] < paired.names[c].size()) continue;
    throw InputError(fmt::format(
        "camera {}: none of its {} images is within {:g} s of one of another "
        "camera (its clock differs from camera {}'s by {:.3g} s); use "
        "--stamps log, or a larger --sync-tolerance-s",
        cameras[c], num_alone[c], tolerance_s, cameras[0], offset_s));
  }
  std::vector<std::string> alone;
  for (size_t c = 0; c < num_cameras; ++c)
    if (num_alone[c] > 0)
      alone.push_back(fmt::format("{} of {}", num_alone[c], cameras[c]));
  paired.remarks.push_back(
      fmt::format("paired {} frames, whose stamps differ by up to {:.3g} ms{}",
                  num_frames, 1e3 * Seconds(largest_ns),
                  alone.empty() ? ""
                                : fmt::format("; images without a partner: {}",
                                              fmt::join(alone, ", "))));
  RemarkTolerance(images, tolerance_s, &paired.remarks);
  return paired;
}

}  // namespace raygrid
