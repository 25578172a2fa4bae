#include <png.h>

#include <climits>
#include <cstdio>

#include "atomic_file.h"
#include "frame_output.h"
#include "rgb_rows.h"

namespace raygrid {
namespace {

// The state used by libpng's callbacks, which must not throw, since libpng is
// written in C.
struct PngWriting {
  AtomicFile* file;
  std::optional<CameraError> error;
};

void WritePngBytes(png_structp png, png_bytep bytes, size_t size) {
  auto* const writing = static_cast<PngWriting*>(png_get_io_ptr(png));
  try {
    writing->file->Write(bytes, size);
    return;
  } catch (const CameraError& error) {
    writing->error = error;
  }
  png_error(png, "output");
}

void FlushNothing(png_structp) {}

// The default error handler of libpng prints messages.
[[noreturn]] void LeaveEncoder(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}

void IgnoreWarning(png_structp, png_const_charp) {}

class PngFiles : public FrameOutput {
 public:
  PngFiles(const std::string& folder, const StreamFormat& format)
      : folder_(folder),
        format_(format),
        pixels_(size_t{3} * format.width * format.height) {
    MakeFolder(folder);
    for (uint32_t i = 0; i < format.height; ++i)
      rows_.push_back(pixels_.data() + size_t{3} * format.width * i);
  }

  void Write(const UndistortedFrame& frame, uint64_t number) override {
    const rg_image image = MakePackedImage(format_, frame.bytes.data());
    for (uint32_t i = 0; i < format_.height; ++i)
      ReadRgbRow(format_, image, i, rows_[i]);
    char path[PATH_MAX];
    std::snprintf(path, sizeof(path), "%s/frame-%06llu.png", folder_.c_str(),
                  static_cast<unsigned long long>(number));
    AtomicFile file(path);
    PngWriting writing = {&file, std::nullopt};
    if (!Encode(&writing))
      throw writing.error.value_or(CameraError(
          CameraExit::kOutput,
          std::string(path) + ": cannot be written as PNG: out of memory"));
    file.Commit();
  }

 private:
  bool Encode(PngWriting* writing) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr,
                                              LeaveEncoder, IgnoreWarning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info) {
      png_destroy_write_struct(&png, nullptr);
      return false;
    }
    const bool is_good = EncodeRows(png, info, writing);
    png_destroy_write_struct(&png, &info);
    return is_good;
  }

  // libpng reports errors by longjmp: no local variable may have a destructor.
  bool EncodeRows(png_structp png, png_infop info, PngWriting* writing) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_write_fn(png, writing, WritePngBytes, FlushNothing);
    png_set_compression_level(png, 1);
    png_set_IHDR(png, info, format_.width, format_.height, 8,
                 PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    png_write_image(png, rows_.data());
    png_write_end(png, info);
    return true;
  }

  const std::string folder_;
  const StreamFormat format_;
  std::vector<uint8_t> pixels_;
  std::vector<png_bytep> rows_;
};

}  // namespace

std::unique_ptr<FrameOutput> MakePngFiles(const std::string& folder,
                                          const StreamFormat& format) {
  return std::make_unique<PngFiles>(folder, format);
}

}  // namespace raygrid
