#include "bags/bag.h"

#include <cstdlib>
#include <fstream>

#include "bags/bag_file.h"
#include "bags/camera_info.h"
#include "bags/compression.h"
#include "bags/image_message.h"
#include "bags/image_topics.h"
#include "bags/message_fields.h"
#include "bags/message_writer.h"
#include "bags/written_bags.h"
#include "support.h"

namespace raygrid {
namespace {

class BagTest : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& contents) {
    const std::string path = folder_ / name;
    std::ofstream(path, std::ios::binary) << contents;
    return path;
  }
  std::string WriteDatabase() {
    const std::string path = folder_ / "run.db3";
    WriteDatabaseBag(path);
    return path;
  }

  TemporaryFolder folder_;
};

// Reads all images of a bag, in all steps. Returns their number.
int ReadAll(const std::string& path) {
  const BagIndex index = IndexBag(path);
  int count = 0;
  for (const ImageTopic& topic : index.topics) {
    const SelectedImages selected = SelectImages(index, topic, {});
    for (const BagImage& image : selected.images) {
      const std::string data = index.bag->Read(image.place);
      ImageMessage message;
      ParseImageMessage(topic.topic, data, &message);
      EXPECT_FALSE(MakeImageFile(message).empty());
      EXPECT_FALSE(FormatStamp(image.stamp_ns).empty());
      ++count;
    }
  }
  return count;
}

void ExpectWrittenImages(const std::string& path) {
  const BagIndex index = IndexBag(path);
  EXPECT_TRUE(index.bag->remarks().empty())
      << path << " " << index.bag->remarks().front();
  ASSERT_EQ(index.topics.size(), 1u) << path;
  const ImageTopic& topic = index.Find("");
  EXPECT_EQ(topic.topic.name, kWrittenTopic);
  EXPECT_EQ(topic.topic.type, "sensor_msgs/Image");
  const SelectedImages selected = SelectImages(index, topic, {});
  EXPECT_TRUE(selected.remarks.empty()) << selected.remarks.front();
  ASSERT_EQ(selected.images.size(), static_cast<size_t>(kWrittenImages));
  for (int k = kWrittenImages - 1; k >= 0; --k) {
    EXPECT_EQ(selected.images[k].stamp_ns, WrittenStamp(k));
    const std::string data = index.bag->Read(selected.images[k].place);
    ImageMessage message;
    ParseImageMessage(topic.topic, data, &message);
    EXPECT_EQ(MakeImageFile(message), "P5\n4 3\n255\n" + WrittenPixels(k));
  }
}

TEST_F(BagTest, IsReadInEveryKindAndCompression) {
  for (const char* method : {"", "lz4", "zstd"})
    ExpectWrittenImages(Write("run.mcap", McapBag(method)));
  for (const char* method : {"none", "lz4", "bz2"})
    ExpectWrittenImages(Write("run.bag", Ros1Bag(method)));
  ExpectWrittenImages(WriteDatabase());
  ExpectWrittenImages(
      Write("run.mcap.zstd", Compressed("zstd", McapBag("lz4"))));
}

TEST_F(BagTest, IsReadUpToItsEndWhereverItIsTruncated) {
  for (const std::string& whole : {McapBag("zstd"), Ros1Bag("none")}) {
    int most = 0;
    for (size_t size = 200; size < whole.size(); size += 7) {
      const std::string path = Write("cut.bag", whole.substr(0, size));
      Bag bag(path);
      int count = 0;
      bag.Scan([&](const BagMessage&) { ++count; });
      EXPECT_GE(count, most);
      most = count;
      if (count < kWrittenImages) {
        EXPECT_EQ(bag.remarks().size(), 1u) << size;
      }
    }
    EXPECT_GE(most, kWrittenImages / 2);
  }
}

TEST_F(BagTest, SkipsADamagedChunkAndSaysSo) {
  std::string bytes = McapBag("");
  bytes[bytes.find(WrittenPixels(4))] ^= 1;
  Bag bag(Write("run.mcap", bytes));
  int count = 0;
  bag.Scan([&](const BagMessage&) { ++count; });
  EXPECT_EQ(count, kWrittenImages / 2);
  ASSERT_EQ(bag.remarks().size(), 1u);
  EXPECT_NE(bag.remarks()[0].find("wrong checksum"), std::string::npos);
}

// A bag with bytes changed, cut, doubled or with extreme numbers.
std::string Damaged(std::string bytes, TestRandom* random) {
  const auto size = static_cast<int>(bytes.size());
  const int kind = random->Index(5), at = random->Index(size);
  if (kind == 0) return bytes.substr(0, at);
  if (kind == 1) return bytes.insert(at, bytes.substr(at, random->Index(200)));
  if (kind == 2) {
    const uint64_t numbers[] = {0, 1, 255, 0x7fffffff, 0xffffffff, ~0ull};
    for (int k = 0, width = random->Index(2) ? 4 : 8; k < width; ++k)
      if (at + k < size)
        bytes[at + k] =
            static_cast<char>(numbers[random->Index(6)] >> 8 * k & 255);
    return bytes;
  }
  for (int k = kind == 3 ? 1 : 10; k > 0; --k)
    bytes[random->Index(size)] = static_cast<char>(random->Index(256));
  return bytes;
}

TEST_F(BagTest, IsReadOrRefusedWithOneLineIfDamaged) {
  const char* const given = std::getenv("RAYGRID_MUTANTS");
  const int count = given ? std::atoi(given) : 40;
  std::vector<std::string> bags;
  std::ifstream database(WriteDatabase(), std::ios::binary);
  bags.emplace_back(std::istreambuf_iterator<char>(database),
                    std::istreambuf_iterator<char>());
  for (const char* method : {"", "lz4", "zstd"})
    bags.push_back(McapBag(method, false));
  for (const char* method : {"none", "lz4", "bz2"})
    bags.push_back(Ros1Bag(method));
  TestRandom random(1);
  int num_read = 0;
  for (const std::string& bag : bags)
    for (int k = 0; k < count; ++k) {
      const std::string path = Write("damaged.bag", Damaged(bag, &random));
      try {
        num_read += ReadAll(path) > 0;
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      }
    }
  EXPECT_GT(num_read, count);
}

std::string ChannelRecord(int id, const std::string& name,
                          const std::string& encoding) {
  std::string content = NumberText(static_cast<uint16_t>(id));
  content += NumberText(uint16_t{1});
  AppendText(name, &content);
  AppendText(encoding, &content);
  AppendText("", &content);
  return content;
}

TEST_F(BagTest, BoundsRemarksAndTopics) {
  std::string bytes = kMcapMagic;
  for (int k = 0; k < 20; ++k) AppendMcapRecord(6, "damaged", &bytes);
  Bag bag(Write("run.mcap", bytes));
  bag.Scan({});
  ASSERT_EQ(bag.remarks().size(), 11u);
  EXPECT_NE(bag.remarks()[10].find(" 11 more"), std::string::npos);
  for (int k = 0; k < 10001; ++k)
    AppendMcapRecord(4, ChannelRecord(k, std::to_string(k), "cdr"), &bytes);
  EXPECT_THROW(Bag(Write("run.mcap", bytes)).Scan({}), Error);
}

TEST_F(BagTest, KeepsTopicsOfOneNameAndDifferentEncodingsApart) {
  std::string bytes = kMcapMagic;
  for (int id : {1, 2, 3})
    AppendMcapRecord(4, ChannelRecord(id, "/cam", id == 1 ? "cdr" : "json"),
                     &bytes);
  Bag bag(Write("run.mcap", bytes));
  bag.Scan({});
  EXPECT_EQ(bag.topics().size(), 2u);
}

TEST_F(BagTest, RefusesADatabaseWithoutItsLog) {
  const std::string path = Write("run.db3", "SQLite format 3, damaged");
  Write("run.db3-wal", "messages");
  try {
    const Bag bag(path);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("run.db3-wal;"),
              std::string::npos);
  }
}

TEST_F(BagTest, IsDecompressedOnlyIfItIsABag) {
  std::ifstream database(WriteDatabase(), std::ios::binary);
  ExpectWrittenImages(
      Write("run.db3.zstd",
            Compressed("zstd", {std::istreambuf_iterator<char>(database),
                                std::istreambuf_iterator<char>()})));
  EXPECT_THROW(Bag(Write("run.mcap.zstd",
                         Compressed("zstd", std::string(1 << 20, 'x')))),
               InputError);
}

// A bag of a message of foxglove.CameraCalibration with packed numbers.
std::string CalibrationBag(int num_k, int num_r) {
  std::string schema = NumberText(uint16_t{1}), data = {'\x2a', '\0'};
  AppendText("foxglove.CameraCalibration", &schema);
  for (const auto& [key, count] : {std::pair{'\x32', num_k}, {'\x3a', num_r}}) {
    data += {key, static_cast<char>(8 * count)};
    for (int k = 0; k < count; ++k) data += NumberText(1.0 + k);
  }
  std::string bytes = kMcapMagic;
  AppendMcapRecord(3, schema, &bytes);
  AppendMcapRecord(4, ChannelRecord(1, "/info", "protobuf"), &bytes);
  AppendMcapRecord(
      5, NumberText(uint16_t{1}) + std::string(4 + 8 + 8, '\0') + data, &bytes);
  return bytes;
}

TEST_F(BagTest, RequiresCompleteMatricesAndAllowsNoCoefficients) {
  std::vector<std::string> remarks;
  const auto read = [&](int num_k, int num_r) {
    return ReadCameraInfo(Write("run.mcap", CalibrationBag(num_k, num_r)), "",
                          &remarks);
  };
  const CameraInfo info = read(9, 0);
  EXPECT_TRUE(info.d.empty());
  EXPECT_EQ(info.k[8], 9);
  EXPECT_EQ(info.p.size(), 12u);
  EXPECT_THROW(read(8, 9), InputError);
  EXPECT_THROW(read(9, 8), InputError);
}

TEST(WriteTransforms, RefusesStampsOutOfRange) {
  StaticTransform transform;
  transform.header.stamp_ns = int64_t{INT32_MAX} * 1000000000;
  EXPECT_NO_THROW(WriteTransforms({transform}));
  transform.header.stamp_ns += 1000000000;
  EXPECT_THROW(WriteTransforms({transform}), InputError);
}

TEST(Decompress, BoundsMemoryByTheData) {
  const std::string zeros(1 << 20, '\0');
  for (const char* method : {"zstd", "lz4", "bz2"}) {
    const std::string data = Compressed(method, zeros);
    EXPECT_EQ(Decompress(method, data, zeros.size()), zeros);
    EXPECT_THROW(Decompress(method, data, zeros.size() - 1), InputError);
    EXPECT_THROW(Decompress(method, data, uint64_t{1} << 60), InputError);
    EXPECT_THROW(
        Decompress(method, data.substr(0, data.size() / 2), zeros.size()),
        InputError);
  }
  EXPECT_EQ(Decompress("zstd", Compressed("zstd", zeros), kUnknownSize), zeros);
}

BagTopic MakeTopic(const std::string& type, MessageEncoding encoding) {
  BagTopic topic;
  topic.type = type;
  topic.encoding = encoding;
  return topic;
}

TEST(ParseImageMessage, ReadsBothByteOrdersOfCdr) {
  const BagTopic topic = MakeTopic("sensor_msgs/Image", MessageEncoding::kCdr);
  for (const ByteOrder order : {ByteOrder::kLittle, ByteOrder::kBig}) {
    const std::string data = CdrImage(2, order);
    ImageMessage message;
    ParseImageMessage(topic, data, &message);
    EXPECT_EQ(message.stamp_ns, WrittenStamp(2));
    EXPECT_EQ(message.data, WrittenPixels(2));
  }
  ImageMessage message;
  EXPECT_THROW(
      ParseImageMessage(
          topic, std::string("\0\2\0\0", 4) + CdrImage(2).substr(4), &message),
      InputError);
}

std::string PixelsAs(const std::string& encoding, const std::string& data,
                     const ImageSize& size, bool is_big_endian = false) {
  ImageMessage message;
  message.encoding = encoding;
  message.size = size;
  message.data = data;
  message.step = data.size() / size.height;
  message.is_big_endian = is_big_endian;
  return MakeImageFile(message);
}

TEST(MakeImageFile, OrdersSamplesAsPnm) {
  EXPECT_EQ(PixelsAs("rgb8", "rgbRGB", {2, 1}), "P6\n2 1\n255\nrgbRGB");
  EXPECT_EQ(PixelsAs("bgr8", "bgrBGR", {2, 1}), "P6\n2 1\n255\nrgbRGB");
  EXPECT_EQ(PixelsAs("rgba8", "rgba", {1, 1}), "P6\n1 1\n255\nrgb");
  EXPECT_EQ(PixelsAs("bgra8", "bgra", {1, 1}), "P6\n1 1\n255\nrgb");
  EXPECT_EQ(PixelsAs("mono16", "lh", {1, 1}), "P5\n1 1\n65535\nhl");
  EXPECT_EQ(PixelsAs("mono16", "hl", {1, 1}, true), "P5\n1 1\n65535\nhl");
  EXPECT_EQ(PixelsAs("yuv422", "u1v2", {2, 1}), "P5\n2 1\n255\n12");
  EXPECT_EQ(PixelsAs("yuv422_yuy2", "1u2v", {2, 1}), "P5\n2 1\n255\n12");
  EXPECT_EQ(PixelsAs("bayer_rggb8", "abcd", {2, 2}), "P5\n2 2\n255\nabcd");
}

TEST(ParseImageMessage, ReadsFoxglove) {
  std::string time, raw;
  time = {'\x08', '\x05', '\x10', '\x07'};  // 5 s, 7 ns
  raw = std::string("\x0a\x04", 2) + time + "\x15" + NumberText(2) + "\x1d" +
        NumberText(1) + "\x22\x05mono8\x2d" + NumberText(2) + "\x32\x02xy" +
        "\x3a\x03" + "cam";
  const BagTopic in_protobuf =
      MakeTopic("foxglove.RawImage", MessageEncoding::kProtobuf);
  ImageMessage message;
  ParseImageMessage(in_protobuf, raw, &message);
  EXPECT_EQ(message.stamp_ns, 5000000007);
  EXPECT_EQ(message.frame_id, "cam");
  EXPECT_EQ(MakeImageFile(message), "P5\n2 1\n255\nxy");
  ParseImageMessage(
      MakeTopic("foxglove.RawImage", MessageEncoding::kJson),
      R"({"timestamp": {"sec": 5, "nsec": 7}, "frame_id": "cam", "width": 2,
          "height": 1, "encoding": "mono8", "step": 2, "data": "eHk="})",
      &message);
  EXPECT_EQ(message.stamp_ns, 5000000007);
  EXPECT_EQ(MakeImageFile(message), "P5\n2 1\n255\nxy");
}

SelectedImages ImagesAt(const std::vector<double>& milliseconds) {
  SelectedImages images;
  for (const double at : milliseconds) {
    BagImage& image = images.images.emplace_back();
    image.stamp_ns = 1000000000 + static_cast<int64_t>(1e6 * at);
    image.log_ns = 1000000000;
  }
  return images;
}

TEST(PairImages, PairsNearStampsAndCountsTheRest) {
  const PairedImages paired = PairImages(
      {"left", "right"},
      {ImagesAt({0, 33, 66, 100}), ImagesAt({0.5, 66.2, 99, 133})}, 0.002);
  const std::vector<std::string> left = {
      "0000000001.000000000", "0000000001.033000000", "0000000001.066000000",
      "0000000001.100000000"};
  const std::vector<std::string> right = {
      "0000000001.000000000", "0000000001.066000000", "0000000001.100000000",
      "0000000001.133000000"};
  EXPECT_EQ(paired.names[0], left);
  EXPECT_EQ(paired.names[1], right);
  EXPECT_NE(paired.remarks[0].find("paired 3 frames"), std::string::npos);
  EXPECT_NE(paired.remarks[0].find("1 of left, 1 of right"), std::string::npos);
  EXPECT_THROW(PairImages({"left", "right"},
                          {ImagesAt({0, 33}), ImagesAt({10000, 10033})}, 0.002),
               InputError);
}

// The names of the right images if the left ones are paired with them in order,
// apart from the first one.
void ExpectPairedFromSecond(const std::vector<double>& left,
                            const std::vector<double>& right,
                            double tolerance_s) {
  const PairedImages paired = PairImages(
      {"left", "right"}, {ImagesAt(left), ImagesAt(right)}, tolerance_s);
  const std::vector<std::string> expected(paired.names[0].begin() + 1,
                                          paired.names[0].end());
  EXPECT_EQ(paired.names[1], expected);
  ASSERT_EQ(paired.remarks.size(), 2u);
  EXPECT_NE(paired.remarks[0].find("1 of left"), std::string::npos);
  EXPECT_NE(paired.remarks[1].find("half the interval"), std::string::npos);
}

TEST(PairImages, PrefersTheNearestToTheEarliest) {
  ExpectPairedFromSecond({0, 5, 10, 15}, {4.9, 9.9, 14.9}, 0.005);
  ExpectPairedFromSecond({0, 33, 67, 100}, {33.5, 66.5, 99.5}, 0.05);
  ExpectPairedFromSecond({0, 10, 20, 30}, {5, 15, 25}, 0.01);  // ties
}

TEST(PairImages, PairsOtherCamerasWithoutTheFirst) {
  const PairedImages paired = PairImages(
      {"a", "b", "c"}, {ImagesAt({0}), ImagesAt({1, 100}), ImagesAt({2, 101})},
      0.005);
  EXPECT_EQ(paired.names[2][0], "0000000001.000000000");
  EXPECT_EQ(paired.names[1], paired.names[2]);
}

}  // namespace
}  // namespace raygrid
