#include "capture_page.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <future>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "camera_error.h"
#include "http_client.h"
#include "rgb_rows.h"

namespace raygrid {
namespace {

using Json = nlohmann::json;
using Kind = CaptureCommand::Kind;
using namespace std::chrono_literals;

const PageOptionNames kWords = {"a-program", "--address", "--page",
                                "--page-name"};

std::vector<uint8_t> Noise(int width, int height) {
  std::mt19937 random(1);
  std::vector<uint8_t> grey(size_t(width) * size_t(height));
  for (uint8_t& value : grey) value = static_cast<uint8_t>(random());
  return grey;
}

// Width and height of a JPEG; nothing for what is none.
std::pair<int, int> JpegSize(const std::string& jpeg) {
  const auto byte = [&jpeg](size_t at) {
    return at < jpeg.size() ? int{static_cast<uint8_t>(jpeg[at])} : 0;
  };
  if (byte(0) != 0xff || byte(1) != 0xd8 || byte(jpeg.size() - 1) != 0xd9)
    return {};
  for (size_t at = 2; at + 8 < jpeg.size();) {
    if (byte(at + 1) == 0xc0)
      return {256 * byte(at + 7) + byte(at + 8),
              256 * byte(at + 5) + byte(at + 6)};
    at += size_t(2 + 256 * byte(at + 2) + byte(at + 3));
  }
  return {};
}

class CapturePageTest : public testing::Test {
 protected:
  void Open(const PageAddress& address = {}) {
    page_ = std::make_unique<CapturePage>(
        address, kWords,
        [this](const CaptureCommand& command) {
          const std::lock_guard<std::mutex> lock(mutex_);
          commands_.push_back(command);
        },
        [this](const std::string& name, GreyBuffer* picture) {
          if (reading_) reading_(name);
          {
            const std::lock_guard<std::mutex> lock(mutex_);
            read_.push_back(name);
          }
          if (name == "lost.png") return false;
          *picture = {1000, 700, Noise(1000, 700)};
          return true;
        });
  }
  void SetUp() override { Open(); }

  void ShowKept(const std::vector<std::string>& names) {
    CaptureState state;
    state.kept = names;
    page_->Show(state);
  }
  void AddKept(const std::string& name, int width, int height) {
    const auto grey = Noise(width, height);
    page_->AddKept(name, grey.data(), width, height, size_t(width));
  }
  int StatusOf(const std::string& request, const std::string& fields = "",
               const std::string& body = "") {
    return HttpClient(page_->port(), request, fields, body).Status();
  }
  std::vector<CaptureCommand> commands() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return commands_;
  }
  std::vector<std::string> read() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return read_;
  }
  std::string own_origin() const {
    return "Origin: http://localhost:" + std::to_string(page_->port()) + "\r\n";
  }

  std::mutex mutex_;
  std::vector<CaptureCommand> commands_;
  std::vector<std::string> read_;
  std::function<void(const std::string&)> reading_;
  std::unique_ptr<CapturePage> page_;
};

// The next state that a client is sent.
Json NextState(HttpClient* client) {
  const std::string event = client->Until("\n\n");
  if (event.compare(0, 6, "data: ") != 0) return nullptr;
  return Json::parse(event.substr(6));
}

// States until one has this hint.
Json StateWithHint(HttpClient* client, const std::string& hint) {
  for (;;) {
    const Json state = NextState(client);
    if (state.is_null() || state["hint"] == hint) return state;
  }
}

TEST_F(CapturePageTest, ServesItsFilesAndNothingOfOthers) {
  HttpClient page(page_->port(), "GET /");
  EXPECT_EQ(page.Status(), 200);
  for (const char* const rule :
       {"default-src 'none'", "script-src 'self'", "frame-ancestors 'none'"})
    EXPECT_NE(page.Head().find(rule), std::string::npos) << rule;
  EXPECT_EQ(page.Head().find("unsafe"), std::string::npos);
  EXPECT_EQ(page.Body().find("://"), std::string::npos);
  for (const auto& [path, type] :
       {std::pair{"/capture.css", "text/css"},
        std::pair{"/capture.js", "text/javascript"}}) {
    HttpClient file(page_->port(), std::string("GET ") + path);
    EXPECT_EQ(file.Status(), 200) << path;
    EXPECT_NE(file.Head().find(type), std::string::npos) << path;
    EXPECT_EQ(file.Body().find("://"), std::string::npos) << path;
  }
}

TEST_F(CapturePageTest, TellsTheStateAsJson) {
  CaptureState state;
  state.width = 640;
  state.height = 480;
  state.camera = "left";
  state.cameras = {{"left", "kept", 0.1}, {"right", "absent", 0}};
  state.links = {{"left", "right", 0.2}};
  state.word = "kept";
  state.hint = "Tilt \"it\"\nnow";
  state.is_done = true;
  state.features = {{1.26, 2}, {639.04, -0.5}};
  state.next = {{{{0, 1}, {2, 3}, {4, 5}}, {{0, 1}, {2, 3}}}};
  state.arrow = {{10, 20}, {30, 40}};
  state.places = {{{5, 6}, 0.123456},
                  {{7, 8}, std::numeric_limits<double>::infinity()}};
  state.stddev_px = std::nan("");
  state.target_px = 0.2;
  state.kept = {"a.png", "b\xff.png"};
  state.num_expected = 9;
  state.warnings = {"<b>"};
  page_->Show(state);
  HttpClient client(page_->port(), "GET /state");
  EXPECT_EQ(client.Status(), 200);
  EXPECT_NE(client.Head().find("text/event-stream"), std::string::npos);
  const Json told = NextState(&client);
  EXPECT_EQ(told["width"], 640);
  EXPECT_EQ(told["height"], 480);
  EXPECT_EQ(told["camera"], "left");
  EXPECT_EQ(
      told["cameras"],
      Json({{{"name", "left"}, {"status", "kept"}, {"uncertainty_px", 0.1}},
            {{"name", "right"},
             {"status", "absent"},
             {"uncertainty_px", 0.0}}}));
  EXPECT_EQ(told["links"][0]["cameras"], Json({"left", "right"}));
  EXPECT_EQ(told["links"][0]["uncertainty_px"], 0.2);
  EXPECT_EQ(told["status"], "kept");
  EXPECT_EQ(told["hint"], state.hint);
  EXPECT_EQ(told["done"], true);
  EXPECT_EQ(told["paused"], false);
  EXPECT_EQ(told["features"], Json({1.3, 2.0, 639.0, -0.5}));
  EXPECT_EQ(told["next_views"][0]["outline"],
            Json({0.0, 1.0, 2.0, 3.0, 4.0, 5.0}));
  EXPECT_EQ(told["next_views"][0]["top"], Json({0.0, 1.0, 2.0, 3.0}));
  EXPECT_EQ(told["arrow"], Json({10.0, 20.0, 30.0, 40.0}));
  EXPECT_EQ(told["uncertainty_map"],
            Json({5.0, 6.0, 0.1235, 7.0, 8.0, nullptr}));
  EXPECT_TRUE(told["uncertainty_px"].is_null());
  EXPECT_EQ(told["requested_uncertainty_px"], 0.2);
  EXPECT_EQ(told["kept_frames"], Json({"a.png", "b\xef\xbf\xbd.png"}));
  EXPECT_EQ(told["frames_remaining"], 9);
  EXPECT_EQ(told["warnings"], Json({"<b>"}));
}

TEST_F(CapturePageTest, RepeatsTheStateWhereNothingHappens) {
  HttpClient client(page_->port(), "GET /state");
  EXPECT_FALSE(NextState(&client).is_null());
  EXPECT_FALSE(NextState(&client).is_null());
}

TEST_F(CapturePageTest, AllWhoWatchGetTheNewestState) {
  std::vector<std::unique_ptr<HttpClient>> clients;
  for (int k = 0; k < 16; ++k) {
    clients.push_back(
        std::make_unique<HttpClient>(page_->port(), "GET /state"));
    EXPECT_FALSE(NextState(clients.back().get()).is_null());
  }
  EXPECT_EQ(StatusOf("GET /state"), 503);
  EXPECT_EQ(StatusOf("GET /"), 200);
  CaptureState state;
  state.hint = "newest";
  page_->Show(state);
  for (const auto& client : clients)
    EXPECT_EQ(StateWithHint(client.get(), "newest")["hint"], "newest");
  clients.pop_back();
  HttpClient other(page_->port(), "GET /state");
  EXPECT_EQ(StateWithHint(&other, "newest")["hint"], "newest");
}

TEST_F(CapturePageTest, WhoIsSlowMissesStatesAndHoldsNobodyUp) {
  HttpClient slow(page_->port(), "GET /state");
  HttpClient fast(page_->port(), "GET /state");
  EXPECT_FALSE(NextState(&slow).is_null());
  EXPECT_FALSE(NextState(&fast).is_null());
  constexpr int kNumStates = 1000;  // 60 MB, more than sockets hold
  CaptureState state;
  state.warnings = {std::string(60000, 'x')};
  std::thread sender([&] {
    for (int k = 0; k <= kNumStates; ++k) {
      state.hint = std::to_string(k);
      page_->Show(state);
    }
  });
  EXPECT_FALSE(StateWithHint(&fast, std::to_string(kNumStates)).is_null());
  sender.join();
  int num_states = 0;
  for (Json told; told.is_null() || told["hint"] != std::to_string(kNumStates);
       ++num_states) {
    told = NextState(&slow);
    ASSERT_FALSE(told.is_null());
  }
  EXPECT_LT(num_states, kNumStates / 2);
}

TEST_F(CapturePageTest, LastStateReachesThoseWhoWatch) {
  HttpClient client(page_->port(), "GET /state");
  EXPECT_FALSE(NextState(&client).is_null());
  CaptureState state;
  state.hint = "goodbye";
  page_->Show(state);
  page_.reset();
  EXPECT_EQ(StateWithHint(&client, "goodbye")["hint"], "goodbye");
  std::string event = client.Until("\n\n");
  while (event.compare(0, 5, "data:") == 0) event = client.Until("\n\n");
  EXPECT_EQ(event, "event: end\ndata: end");
  EXPECT_TRUE(NextState(&client).is_null());
}

TEST_F(CapturePageTest, CommandsReachTheProgram) {
  const std::string name = "a \"b\"<i>&+%41/\xc3\xbc.png";
  ShowKept({name, "plain_1.png"});
  for (const char* const path : {"/pause", "/go-on", "/undo", "/finish"})
    EXPECT_EQ(StatusOf(std::string("POST ") + path), 202) << path;
  EXPECT_EQ(
      StatusOf("POST /delete?name=a%20%22b%22%3Ci%3E%26%2B%2541%2F%C3%BC.png",
               own_origin() + "Sec-Fetch-Site: same-origin\r\n"),
      202);
  EXPECT_EQ(StatusOf("POST /pause", "", std::string(100000, 'x')), 202);
  const auto found = commands();
  ASSERT_EQ(found.size(), 6u);
  const Kind kinds[] = {Kind::kPause,  Kind::kGoOn,   Kind::kUndo,
                        Kind::kFinish, Kind::kDelete, Kind::kPause};
  for (size_t k = 0; k < found.size(); ++k)
    EXPECT_EQ(found[k].kind, kinds[k]) << k;
  EXPECT_EQ(found[4].name, name);
  EXPECT_EQ(found[0].name, "");
}

TEST_F(CapturePageTest, OtherCommandsAreNone) {
  ShowKept({"a.png", ""});
  for (const char* const request :
       {"POST /delete", "POST /delete?name=b.png", "POST /delete?name=a.png%00",
        "POST /delete?name=%61.png", "POST /delete?name=..%2Fa.png", "POST /",
        "POST /state", "POST /pause/", "POST //pause", "POST /kept/a.png.jpg"})
    EXPECT_EQ(StatusOf(request), 404) << request;
  for (const char* const path :
       {"/pause", "/go-on", "/undo", "/finish", "/delete?name=a.png"}) {
    EXPECT_EQ(StatusOf(std::string("GET ") + path), 405) << path;
    EXPECT_EQ(StatusOf(std::string("PUT ") + path), 405) << path;
    EXPECT_EQ(StatusOf(std::string("HEAD ") + path), 405) << path;
  }
  EXPECT_TRUE(commands().empty());
}

TEST_F(CapturePageTest, NoOtherSitesPageCommands) {
  const std::string port = std::to_string(page_->port());
  for (const std::string& field :
       {std::string("Origin: http://evil.example"), std::string("Origin: null"),
        std::string("Origin: "), "Origin: http://evil.example:" + port,
        "Origin: http://localhost:" + std::to_string(page_->port() + 1),
        "Origin: http://localhost:" + port + ".evil.example",
        "Origin: http://localhost:" + port + "@evil.example",
        "Origin: ftp://localhost:" + port, "Origin: localhost:" + port,
        "origin: http://localhost:" + port + "\r\nOrigin: http://evil.example",
        std::string("Sec-Fetch-Site: cross-site"),
        std::string("Sec-Fetch-Site: same-site"),
        std::string("Sec-Fetch-Site: none"),
        "Origin: http://localhost:" + port + "\r\nSec-Fetch-Site: cross-site"})
    EXPECT_EQ(StatusOf("POST /finish", field + "\r\n"), 403) << field;
  for (const std::string& host :
       {std::string("evil.example"), "evil.example:" + port})
    for (const char* const request : {"POST /finish", "GET /state", "GET /"})
      EXPECT_EQ(StatusOf(request, "Host: " + host + "\r\n"), 421) << host;
  EXPECT_TRUE(commands().empty());
  EXPECT_EQ(StatusOf("POST /finish", own_origin()), 202);
}

TEST_F(CapturePageTest, WhoAsksFromElsewhereMustKnowTheToken) {
  PageAddress address;
  address.number = "0.0.0.0";
  Open(address);
  ShowKept({"a.png"});
  EXPECT_TRUE(page_->has_new_token());
  const std::string link = page_->link();
  const std::string token = link.substr(link.find("token=") + 6);
  EXPECT_EQ(token.size(), 32u);
  const std::string cookie = "raygrid_" + std::to_string(page_->port()) + "=";
  for (const char* const request :
       {"GET /", "GET /state", "GET /live", "GET /capture.js",
        "GET /kept/a.png.jpg", "GET /picture/a.png.jpg", "GET /nothing",
        "POST /finish", "POST /delete?name=a.png"}) {
    EXPECT_EQ(StatusOf(request), 401) << request;
    EXPECT_EQ(StatusOf(request, "Cookie: " + cookie + "0" + token + "\r\n"),
              401)
        << request;
  }
  EXPECT_TRUE(commands().empty());
  EXPECT_EQ(StatusOf("POST /finish", "Cookie: " + cookie + token + "\r\n"),
            202);
  EXPECT_EQ(StatusOf("GET /", "Authorization: Bearer " + token + "\r\n"), 200);
  EXPECT_EQ(StatusOf("GET /?token=" + token), 303);
}

TEST_F(CapturePageTest, ErrorsNameTheProgramsOptions) {
  PageAddress address;
  address.port = page_->port();
  const auto message_of = [&address] {
    try {
      CapturePage(address, kWords, nullptr, nullptr);
    } catch (const CameraError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(
      message_of().find("--page: 127.0.0.1:" + std::to_string(address.port)),
      0u)
      << message_of();
  address.number = "nowhere";
  EXPECT_EQ(message_of().find("--address: nowhere"), 0u) << message_of();
  HttpClient client(page_->port(), "GET /", "Host: evil.example\r\n");
  EXPECT_NE(client.Body().find("a-program --page-name"), std::string::npos);
}

TEST_F(CapturePageTest, PortZeroIsAnyThatIsFree) {
  CapturePage other({}, kWords, nullptr, nullptr);
  EXPECT_NE(other.port(), 0);
  EXPECT_NE(other.port(), page_->port());
  EXPECT_EQ(other.link(),
            "http://127.0.0.1:" + std::to_string(other.port()) + "/");
  EXPECT_EQ(HttpClient(other.port(), "POST /pause").Status(), 202);
}

TEST_F(CapturePageTest, PortIsFreeAgainAtOnce) {
  PageAddress address;
  address.port = page_->port();
  HttpClient client(page_->port(), "GET /state");
  EXPECT_FALSE(NextState(&client).is_null());
  page_.reset();  // the server's end closes first
  Open(address);
  EXPECT_EQ(StatusOf("GET /"), 200);
}

TEST_F(CapturePageTest, SmallPicturesAreSmall) {
  for (const auto& [width, height, small_width, small_height] :
       {std::array{1601, 900, 266, 150}, std::array{240, 2000, 34, 285},
        std::array{320, 10, 320, 10}, std::array{3, 1, 3, 1}}) {
    AddKept("a b.png", width, height);
    ShowKept({"a b.png"});
    HttpClient client(page_->port(), "GET /kept/a%20b.png.jpg");
    EXPECT_EQ(client.Status(), 200);
    const std::string jpeg = client.Body();
    EXPECT_LE(jpeg.size(), 24u * 1024);
    EXPECT_EQ(JpegSize(jpeg), std::pair(small_width, small_height))
        << width << " x " << height;
  }
  const auto flat = std::vector<uint8_t>(640 * 480, 77);
  page_->AddKept("flat.png", flat.data(), 640, 480, 640);
  ShowKept({"flat.png"});
  EXPECT_EQ(
      JpegSize(HttpClient(page_->port(), "GET /kept/flat.png.jpg").Body()),
      std::pair(320, 240));
}

TEST_F(CapturePageTest, OnlyKeptFramesHavePictures) {
  AddKept("a.png", 64, 48);
  EXPECT_EQ(StatusOf("GET /kept/a.png.jpg"), 404);  // no state has it yet
  ShowKept({"a.png", "late.png"});
  EXPECT_EQ(StatusOf("GET /kept/a.png.jpg"), 200);
  EXPECT_EQ(StatusOf("GET /kept/late.png.jpg"), 404);
  AddKept("late.png", 64, 48);
  EXPECT_EQ(StatusOf("GET /kept/late.png.jpg"), 200);
  for (const char* const path :
       {"/kept/a.png", "/kept/.jpg", "/kept/", "/kept/b.png.jpg",
        "/kept/%61.png.jpg", "/kept/a.png%00.jpg", "/kept/../kept/a.png.jpg",
        "/kept/..%2Fa.png.jpg", "/picture/..%2F..%2Fetc%2Fpasswd.jpg",
        "/picture/b.png.jpg", "/etc/passwd", "//", "/live/", "/state.jpg"})
    EXPECT_EQ(StatusOf(std::string("GET ") + path), 404) << path;
  EXPECT_TRUE(read().empty());
  ShowKept({"late.png"});
  EXPECT_EQ(StatusOf("GET /kept/a.png.jpg"), 404);
  ShowKept({"a.png"});  // another frame of this name: its picture was forgotten
  EXPECT_EQ(StatusOf("GET /kept/a.png.jpg"), 404);
}

TEST_F(CapturePageTest, WholePicturesAreReadWhenAskedFor) {
  ShowKept({"a.png", "lost.png"});
  HttpClient client(page_->port(), "GET /picture/a.png.jpg");
  bool is_whole = false;
  EXPECT_EQ(client.Status(), 200);
  EXPECT_EQ(JpegSize(client.Body(&is_whole)), std::pair(1000, 700));
  EXPECT_TRUE(is_whole);
  HttpClient lost(page_->port(), "GET /picture/lost.png.jpg");
  EXPECT_EQ(lost.Body(&is_whole), "");
  EXPECT_FALSE(is_whole);
  EXPECT_EQ(read(), (std::vector<std::string>{"a.png", "lost.png"}));
}

TEST_F(CapturePageTest, SlowDiskHoldsNobodyUp) {
  std::promise<void> is_read;
  reading_ = [future = is_read.get_future().share()](const std::string&) {
    future.wait();
  };
  ShowKept({"a.png"});
  HttpClient first(page_->port(), "GET /picture/a.png.jpg");
  { HttpClient gone(page_->port(), "GET /picture/a.png.jpg"); }
  HttpClient second(page_->port(), "GET /picture/a.png.jpg");
  EXPECT_EQ(StatusOf("GET /"), 200);
  HttpClient state(page_->port(), "GET /state");
  EXPECT_FALSE(NextState(&state).is_null());
  is_read.set_value();
  EXPECT_EQ(JpegSize(first.Body()), std::pair(1000, 700));
  EXPECT_EQ(JpegSize(second.Body()), std::pair(1000, 700));
  // Those who still wait when the page ends are let go.
  std::promise<void> is_read_late;
  reading_ = [future = is_read_late.get_future().share()](const std::string&) {
    future.wait();
  };
  HttpClient third(page_->port(), "GET /picture/a.png.jpg");
  HttpClient fourth(page_->port(), "GET /picture/a.png.jpg");
  EXPECT_EQ(third.Status(), 200);
  EXPECT_EQ(fourth.Status(), 200);
  std::thread late([&] {
    std::this_thread::sleep_for(100ms);
    is_read_late.set_value();
  });
  page_.reset();
  late.join();
  fourth.Body();
}

// The next picture of a stream, once what tells its end has come.
std::string NextPicture(HttpClient* client) {
  for (;;) {
    const std::string picture = client->Until(
        "\r\n--raygrid-live-picture\r\nContent-Type: image/jpeg\r\n\r\n");
    if (!picture.empty()) return picture;
    if (!client->is_open()) return "";
  }
}

TEST_F(CapturePageTest, LivePicturesAreThoseOfFrames) {
  HttpClient client(page_->port(), "GET /live");
  EXPECT_NE(client.Head().find("multipart/x-mixed-replace"), std::string::npos);
  const auto grey = Noise(2600, 1300);
  page_->ShowImage(grey.data(), 2600, 1300, 2600);
  EXPECT_EQ(JpegSize(NextPicture(&client)), std::pair(866, 433));
  for (const char* const name : {"YUYV", "SRGGB8", "BGR888", "R16"}) {
    const PixelFormatInfo* const pixel_format = FindPixelFormat(name);
    ASSERT_TRUE(pixel_format) << name;
    const StreamFormat format = MakeStreamFormat(*pixel_format, 642, 480, 0);
    const std::vector<uint8_t> bytes(format.packed_size(), 99);
    page_->ShowImage(grey.data(), 100, 100, 2600);
    page_->ShowImage(format, MakePackedImage(format, bytes.data()));
    // The newest frame is always shown, others perhaps.
    std::pair<int, int> size = JpegSize(NextPicture(&client));
    if (size == std::pair(100, 100)) size = JpegSize(NextPicture(&client));
    EXPECT_EQ(size, std::pair(642, 480)) << name;
  }
}

TEST_F(CapturePageTest, PicturesThatNobodyWatchesCostNothing) {
  const auto grey = Noise(4000, 3000);
  const std::clock_t start = std::clock();  // of the processor
  for (int k = 0; k < 1000; ++k)
    page_->ShowImage(grey.data(), 4000, 3000, 4000);
  // Copies alone would take more than a second.
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 0.1);
}

}  // namespace
}  // namespace raygrid
