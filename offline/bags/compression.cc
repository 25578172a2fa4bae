#include "bags/compression.h"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <memory>
#include <vector>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

constexpr size_t kStepBytes = 1 << 18;

// Result of a call of a Decompressor.
struct DecompressedChunk {
  size_t written = 0;    // bytes of output
  bool is_done = false;  // at the end of a frame
  bool is_corrupt = false;
};
// Decompresses a part of the input into a buffer of the given size, and removes
// what was read from `in`.
using Decompressor =
    std::function<DecompressedChunk(std::string_view* in, char* out, size_t)>;

struct FreeZstd {
  void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
};
struct FreeLz4 {
  void operator()(LZ4F_dctx* context) const {
    LZ4F_freeDecompressionContext(context);
  }
};
struct FreeBzip2 {
  void operator()(bz_stream* stream) const {
    BZ2_bzDecompressEnd(stream);
    delete stream;
  }
};

Decompressor MakeZstdDecompressor() {
  std::shared_ptr<ZSTD_DStream> stream(ZSTD_createDStream(), FreeZstd());
  return [stream](std::string_view* in, char* out, size_t room) {
    ZSTD_inBuffer input = {in->data(), in->size(), 0};
    ZSTD_outBuffer output = {out, room, 0};
    const size_t rest = ZSTD_decompressStream(stream.get(), &output, &input);
    in->remove_prefix(input.pos);
    return DecompressedChunk{output.pos, rest == 0, ZSTD_isError(rest) != 0};
  };
}

Decompressor MakeLz4Decompressor() {
  LZ4F_dctx* created = nullptr;
  LZ4F_createDecompressionContext(&created, LZ4F_VERSION);
  std::shared_ptr<LZ4F_dctx> context(created, FreeLz4());
  return [context](std::string_view* in, char* out, size_t room) {
    size_t num_read = in->size();
    const size_t rest = LZ4F_decompress(context.get(), out, &room, in->data(),
                                        &num_read, nullptr);
    if (LZ4F_isError(rest)) return DecompressedChunk{0, false, true};
    in->remove_prefix(num_read);
    return DecompressedChunk{room, rest == 0, false};
  };
}

Decompressor MakeBzip2Decompressor() {
  auto* created = new bz_stream();
  BZ2_bzDecompressInit(created, 0, 0);
  std::shared_ptr<bz_stream> stream(created, FreeBzip2());
  return [stream](std::string_view* in, char* out, size_t room) {
    stream->next_in = const_cast<char*>(in->data());
    stream->avail_in =
        static_cast<unsigned>(std::min(in->size(), size_t{1} << 30));
    const unsigned before = stream->avail_in;
    stream->next_out = out;
    stream->avail_out = static_cast<unsigned>(room);
    const int result = BZ2_bzDecompress(stream.get());
    in->remove_prefix(before - stream->avail_in);
    return DecompressedChunk{room - stream->avail_out, result == BZ_STREAM_END,
                             result != BZ_OK && result != BZ_STREAM_END};
  };
}

Decompressor MakeDecompressor(const std::string& method) {
  if (method == "zstd") return MakeZstdDecompressor();
  if (method == "lz4") return MakeLz4Decompressor();
  if (method == "bz2") return MakeBzip2Decompressor();
  throw InputError(
      fmt::format("unknown compression '{}' (supported: none, lz4, zstd, bz2)",
                  Printable(method.substr(0, 40))));
}

[[noreturn]] void ThrowCorrupt(const std::string& method) {
  throw InputError(fmt::format("corrupt {} data", method));
}

void RequireSize(uint64_t size, uint64_t expected) {
  if (expected != kUnknownSize && size != expected)
    throw InputError(fmt::format(
        "has {} bytes after decompression, expected {}", size, expected));
}

void RequireWritten(const std::ofstream& output, const std::string& path) {
  if (!output)
    throw Error(ExitCode::kOutputFailed,
                path +
                    ": cannot be written; the decompressed bag needs space, "
                    "set TMPDIR to a folder that has it");
}

}  // namespace

std::string Decompress(const std::string& method, std::string_view data,
                       uint64_t size) {
  if (method.empty() || method == "none") {
    RequireSize(data.size(), size);
    return std::string(data);
  }
  const Decompressor decompress = MakeDecompressor(method);
  const uint64_t limit = std::min(size, kMaxChunkBytes);
  std::string text;
  bool is_done = data.empty();
  while (!is_done) {
    const size_t before = text.size();
    // One byte more than expected, to notice more.
    text.resize(std::min(std::max(2 * before, kStepBytes), size_t{limit} + 1));
    if (text.size() == before)
      throw InputError(
          fmt::format("has more than {} bytes after decompression", limit));
    const std::string_view rest = data;
    const DecompressedChunk done =
        decompress(&data, &text[before], text.size() - before);
    if (done.is_corrupt) ThrowCorrupt(method);
    text.resize(before + done.written);
    // Frames may follow each other.
    is_done = done.is_done && (data.empty() || method == "bz2");
    if (!is_done && done.written == 0 && data.size() == rest.size())
      ThrowCorrupt(method);
  }
  if (text.size() > limit)
    throw InputError(
        fmt::format("has more than {} bytes after decompression", limit));
  RequireSize(text.size(), size);
  return text;
}

bool IsZstd(std::string_view data) {
  return data.substr(0, 4) == "\x28\xb5\x2f\xfd";
}

void DecompressZstdFile(const std::string& from, const std::string& to,
                        const std::function<void(const std::string&)>& check) {
  std::ifstream input(from, std::ios::binary);
  std::ofstream output(to, std::ios::binary);
  std::vector<char> in(kStepBytes), out(kStepBytes);
  const Decompressor decompress = MakeZstdDecompressor();
  bool is_done = true, is_checked = false;
  while (input.read(in.data(), static_cast<std::streamsize>(in.size())),
         input.gcount() > 0) {
    std::string_view rest(in.data(), static_cast<size_t>(input.gcount()));
    bool is_full = true;
    while (!rest.empty() || is_full) {
      const size_t before = rest.size();
      const DecompressedChunk done = decompress(&rest, out.data(), out.size());
      if (done.is_corrupt)
        throw InputError(from + ": corrupt zstd data; copy it again");
      if (!is_checked && done.written > 0)
        check(std::string(out.data(), done.written));
      is_checked |= done.written > 0;
      output.write(out.data(), static_cast<std::streamsize>(done.written));
      RequireWritten(output, to);
      is_full = done.written == out.size();
      if (done.written > 0 || rest.size() < before) is_done = done.is_done;
    }
  }
  output.flush();
  RequireWritten(output, to);
  if (!is_done) throw InputError(from + ": truncated; copy it again");
}

}  // namespace raygrid
