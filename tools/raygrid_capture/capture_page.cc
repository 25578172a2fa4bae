#include "capture_page.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "capture_json.h"
#include "downscaled_jpeg.h"
#include "full_size_images.h"
#include "live_preview.h"
#include "newest_stream.h"
#include "page_files.h"
#include "thumbnail_store.h"

namespace raygrid {
namespace {

// The page assumes that the connection is lost after a longer silence.
constexpr std::chrono::seconds kMaxUpdateInterval(2);
constexpr std::chrono::milliseconds kShutdownTimeout(500);
constexpr size_t kReservedStateSize = 32 * 1024;

constexpr char kPolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' "
    "data:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

// Escapes a name like encodeURIComponent().
std::string EscapedName(const std::string& name) {
  constexpr char kPlain[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.!~*'()";
  constexpr char kDigits[] = "0123456789ABCDEF";
  const std::string plain = kPlain;
  std::string out;
  for (const char letter : name) {
    if (plain.find(letter) != std::string::npos) {
      out += letter;
      continue;
    }
    const auto byte = static_cast<unsigned char>(letter);
    out += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return out;
}

// Parses a path FOLDER/NAME.jpg into its escaped name; returns false for other
// paths.
bool ParseImagePath(const std::string& path, const std::string& folder,
                    std::string* name) {
  const std::string end = ".jpg";
  if (path.size() < folder.size() + end.size() ||
      path.compare(0, folder.size(), folder) != 0 ||
      path.compare(path.size() - end.size(), end.size(), end) != 0)
    return false;
  *name = path.substr(folder.size(), path.size() - folder.size() - end.size());
  return true;
}

const std::map<std::string, CaptureCommand::Kind>& Commands() {
  using Kind = CaptureCommand::Kind;
  static const std::map<std::string, Kind> commands = {
      {"/pause", Kind::kPause},
      {"/go-on", Kind::kGoOn},
      {"/undo", Kind::kUndo},
      {"/finish", Kind::kFinish},
      {"/delete", Kind::kDelete}};
  return commands;
}

MHD_Result AnswerPlain(MHD_Connection* connection, unsigned status,
                       const char* text) {
  return AnswerText(connection, status, "text/plain; charset=utf-8", text);
}

MHD_Result AnswerFile(MHD_Connection* connection, const char* type,
                      const char* text) {
  return AnswerText(connection, MHD_HTTP_OK, type, text,
                    {{"Content-Security-Policy", kPolicy},
                     {"Referrer-Policy", "no-referrer"},
                     {MHD_HTTP_HEADER_CACHE_CONTROL, "no-cache"}});
}

}  // namespace

class CapturePage::Impl {
 public:
  Impl(const PageAddress& address, const PageOptionNames& words,
       OnCommand on_command, KeptFrameReader read_kept);
  ~Impl();
  const PageServer& server() const { return server_; }
  void Show(const CaptureState& state);
  LivePreview* live() { return &live_; }
  ThumbnailStore* kept() { return &kept_; }

 private:
  MHD_Result Answer(MHD_Connection* connection, const std::string& path,
                    bool is_post);
  MHD_Result AnswerCommand(MHD_Connection* connection, const std::string& path);
  // Finds the name with this escaped form; returns false if no frame has it.
  bool DecodeName(const std::string& escaped, std::string* name);
  void RepeatState();

  const OnCommand on_command_;
  std::mutex mutex_;  // guards all members below
  std::condition_variable changed_;
  std::string json_;
  std::map<std::string, std::string> names_;  // names of kept frames, by
                                              // escaped name
  bool is_new_ = false, is_stopped_ = false;
  NewestStream states_{"text/event-stream", "", kReservedStateSize};
  ThumbnailStore kept_;
  LivePreview live_;
  FullSizeImages full_size_images_;
  PageServer server_;
  std::thread repeat_thread_;
};

CapturePage::Impl::Impl(const PageAddress& address,
                        const PageOptionNames& words, OnCommand on_command,
                        KeptFrameReader read_kept)
    : on_command_(std::move(on_command)),
      json_(CaptureJson({})),
      full_size_images_(std::move(read_kept)),
      server_(
          address, words, true,
          [this](MHD_Connection* connection, const std::string& path,
                 bool is_post) { return Answer(connection, path, is_post); }),
      repeat_thread_(&Impl::RepeatState, this) {}

CapturePage::Impl::~Impl() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  changed_.notify_one();
  repeat_thread_.join();
  live_.End();
  full_size_images_.End();
  // Repeats the state, which may not have been sent yet.
  states_.Publish({"data: ", json_, "\n\nevent: end\ndata: end\n\n"});
  states_.End();
  const auto end = std::chrono::steady_clock::now() + kShutdownTimeout;
  while (states_.has_clients() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

void CapturePage::Impl::Show(const CaptureState& state) {
  std::string json = CaptureJson(state);
  std::map<std::string, std::string> names;
  for (const std::string& name : state.kept) names[EscapedName(name)] = name;
  kept_.KeepOnly(state.kept);
  const std::lock_guard<std::mutex> lock(mutex_);
  json_ = std::move(json);
  names_ = std::move(names);
  is_new_ = true;
  states_.Publish({"data: ", json_, "\n\n"});
}

// Sends the state regularly, so that clients can distinguish a static scene
// from a lost connection.
void CapturePage::Impl::RepeatState() {
  std::unique_lock<std::mutex> lock(mutex_);
  do {
    if (!is_new_) states_.Publish({"data: ", json_, "\n\n"});
    is_new_ = false;
  } while (!changed_.wait_for(lock, kMaxUpdateInterval,
                              [this] { return is_stopped_; }));
}

bool CapturePage::Impl::DecodeName(const std::string& escaped,
                                   std::string* name) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = names_.find(escaped);
  if (found == names_.end()) return false;
  *name = found->second;
  return true;
}

MHD_Result CapturePage::Impl::AnswerCommand(MHD_Connection* connection,
                                            const std::string& path) {
  const auto found = Commands().find(path);
  if (found == Commands().end())
    return AnswerPlain(connection, MHD_HTTP_NOT_FOUND, "unknown command\n");
  CaptureCommand command;
  command.kind = found->second;
  if (command.kind == CaptureCommand::Kind::kDelete) {
    const char* const escaped =
        MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "name");
    if (!escaped || !DecodeName(escaped, &command.name))
      return AnswerPlain(connection, MHD_HTTP_NOT_FOUND, "no such frame\n");
  }
  if (on_command_) on_command_(command);
  return AnswerPlain(connection, MHD_HTTP_ACCEPTED, "accepted\n");
}

MHD_Result CapturePage::Impl::Answer(MHD_Connection* connection,
                                     const std::string& path, bool is_post) {
  if (is_post) return AnswerCommand(connection, path);
  if (Commands().count(path) > 0)
    return AnswerText(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "text/plain",
                      "only POST is supported\n",
                      {{MHD_HTTP_HEADER_ALLOW, "POST"}});
  if (path == "/")
    return AnswerFile(connection, "text/html; charset=utf-8", kCaptureHtml);
  if (path == "/capture.css")
    return AnswerFile(connection, "text/css; charset=utf-8", kCaptureStyle);
  if (path == "/capture.js")
    return AnswerFile(connection, "text/javascript; charset=utf-8",
                      kCaptureScript);
  if (path == "/state") return server_.AnswerStream(connection, &states_);
  if (path == "/live") return server_.AnswerStream(connection, live_.stream());
  std::string escaped, name;
  if (ParseImagePath(path, "/kept/", &escaped) && DecodeName(escaped, &name)) {
    const std::vector<uint8_t> jpeg = kept_.Find(name);
    if (!jpeg.empty())
      return AnswerBytes(connection, "image/jpeg", jpeg,
                         {{MHD_HTTP_HEADER_CACHE_CONTROL, "no-store"}});
  }
  if (ParseImagePath(path, "/picture/", &escaped) && DecodeName(escaped, &name))
    return full_size_images_.Answer(connection, name);
  return AnswerPlain(connection, MHD_HTTP_NOT_FOUND, "not found\n");
}

CapturePage::CapturePage(const PageAddress& address,
                         const PageOptionNames& words, OnCommand on_command,
                         KeptFrameReader read_kept)
    : impl_(std::make_unique<Impl>(address, words, std::move(on_command),
                                   std::move(read_kept))) {}

CapturePage::~CapturePage() = default;

uint16_t CapturePage::port() const { return impl_->server().port(); }
std::string CapturePage::link() const { return impl_->server().link(); }
bool CapturePage::has_new_token() const {
  return impl_->server().has_new_token();
}

void CapturePage::Show(const CaptureState& state) { impl_->Show(state); }

void CapturePage::ShowImage(const StreamFormat& format, const rg_image& image) {
  impl_->live()->Show(format, image);
}

void CapturePage::ShowImage(const uint8_t* grey, int width, int height,
                            size_t row_bytes) {
  if (!impl_->live()->stream()->has_clients()) return;
  const StreamFormat format = MakeGreyFormat(width, height);
  impl_->live()->Show(format, MakeGreyImage(format, grey, row_bytes));
}

void CapturePage::AddKept(const std::string& name, const uint8_t* grey,
                          int width, int height, size_t row_bytes) {
  const StreamFormat format = MakeGreyFormat(width, height);
  impl_->kept()->Add(name, format, MakeGreyImage(format, grey, row_bytes));
}

}  // namespace raygrid
