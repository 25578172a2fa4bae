#include "exchange/exr.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>

namespace raygrid {
namespace {

// In-memory output stream for OpenEXR, which seeks while writing.
class ExrBytes : public Imf::OStream {
 public:
  ExrBytes() : Imf::OStream("EXR") {}
  void write(const char bytes[], int count) override {
    if (at_ + count > bytes_.size()) bytes_.resize(at_ + count);
    bytes_.replace(at_, count, bytes, count);
    at_ += count;
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t at) override { at_ = at; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  size_t at_ = 0;
};

}  // namespace

std::string WriteExr(const ImageSize& size,
                     const std::vector<std::string>& channels,
                     const std::vector<float>& numbers) {
  Imf::Header header(size.width, size.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer buffer;
  char* const first =
      reinterpret_cast<char*>(const_cast<float*>(numbers.data()));
  const size_t pixel_bytes = channels.size() * sizeof(float);
  for (size_t c = 0; c < channels.size(); ++c) {
    header.channels().insert(channels[c], Imf::Channel(Imf::FLOAT));
    buffer.insert(channels[c],
                  Imf::Slice(Imf::FLOAT, first + c * sizeof(float), pixel_bytes,
                             pixel_bytes * size.width));
  }
  ExrBytes bytes;
  {
    Imf::OutputFile file(bytes, header);
    file.setFrameBuffer(buffer);
    file.writePixels(size.height);
  }  // the destructor completes the file
  return bytes.bytes();
}

}  // namespace raygrid
