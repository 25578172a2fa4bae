#include "live_frames.h"

#include <fmt/format.h>

#include <filesystem>

#include "camera_error.h"
#include "dataset/error.h"
#include "dataset/image_header.h"
#include "dataset/text_encoding.h"
#include "grey_frame.h"

namespace raygrid {
namespace {

class FolderFrames : public LiveFrames {
 public:
  explicit FolderFrames(const std::string& folder)
      : paths_(FindImages({folder}).paths) {}

  std::optional<LiveFrame> Next() override {
    while (!is_finished()) {
      const std::string& path = paths_[next_++];
      try {
        return Read(path);
      } catch (const InputError& error) {
        fmt::print(stderr, "raygrid-capture: skipped {}\n",
                   Printable(error.what()));
      }
    }
    return std::nullopt;
  }
  bool is_finished() const override { return next_ == paths_.size(); }
  bool is_live() const override { return false; }
  std::optional<double> done() const override {
    return static_cast<double>(next_) / static_cast<double>(paths_.size());
  }

 private:
  LiveFrame Read(const std::string& path) {
    LiveFrame frame;
    frame.image = ReadGreyAsStored(path);
    if (!size_) size_ = frame.image.size;
    if (frame.image.size != *size_)
      throw InputError(
          fmt::format("{}: {} x {} pixels, but the first image has {} x {}",
                      path, frame.image.size.width, frame.image.size.height,
                      size_->width, size_->height));
    frame.grey = MakeGreyImage(ReadGreyLevels(path));
    frame.name = std::filesystem::path(path).filename().string();
    frame.path = path;
    return frame;
  }

  const std::vector<std::string> paths_;
  size_t next_ = 0;
  std::optional<ImageSize> size_;
};

class SourceFrames : public LiveFrames {
 public:
  SourceFrames(std::unique_ptr<FrameSource> source, bool is_live)
      : source_(std::move(source)), is_live_(is_live) {
    RequireGrey(*source_->format().pixel_format);
    source_->Start();
  }
  ~SourceFrames() override { source_->Stop(); }

  std::optional<LiveFrame> Next() override {
    constexpr std::chrono::milliseconds kPatience(50);
    const auto captured = source_->Next(kPatience);
    if (!captured) {
      if (!source_->fault().empty())
        throw CameraError(CameraExit::kInput, source_->fault());
      return std::nullopt;
    }
    LiveFrame frame;
    frame.image = ConvertToGrey(source_->format(), captured->image);
    frame.info = captured->info;
    frame.arrived = captured->arrived;
    source_->Release(*captured);
    frame.grey = MakeGreyImage(frame.image);
    frame.time_s = GetTime(frame.info);
    ++num_taken_;
    return frame;
  }
  // Not finished while there is an error, which Next() reports.
  bool is_finished() const override {
    return source_->is_finished() && source_->fault().empty();
  }
  bool is_live() const override { return is_live_; }
  FrameSource* source() override { return source_.get(); }

 private:
  // Frames of a file have no arrival times: a constant rate is assumed.
  double GetTime(const FrameInfo& info) {
    constexpr double kFileFrameS = 1 / 30.0;
    if (!is_live_) return num_taken_ * kFileFrameS;
    if (!first_ns_) first_ns_ = info.timestamp_ns;
    return static_cast<double>(info.timestamp_ns - *first_ns_) * 1e-9;
  }

  const std::unique_ptr<FrameSource> source_;
  const bool is_live_;
  std::optional<uint64_t> first_ns_;
  double num_taken_ = 0;
};

}  // namespace

std::unique_ptr<LiveFrames> MakeFolderFrames(const std::string& folder) {
  return std::make_unique<FolderFrames>(folder);
}

std::unique_ptr<LiveFrames> MakeSourceFrames(
    std::unique_ptr<FrameSource> source, bool is_live) {
  return std::make_unique<SourceFrames>(std::move(source), is_live);
}

}  // namespace raygrid
