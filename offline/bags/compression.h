#ifndef RAYGRID_BAGS_COMPRESSION_H
#define RAYGRID_BAGS_COMPRESSION_H

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace raygrid {

/// Chunks and messages are at most this large.
constexpr uint64_t kMaxChunkBytes = uint64_t{1} << 30;

/// Decompresses data of a method: "", "none", "lz4", "zstd", "bz2". Memory
/// grows with the data, not with `size`, which may be wrong. Throws InputError,
/// without a file's name, if the data are corrupt, do not have this size, or
/// exceed kMaxChunkBytes.
std::string Decompress(const std::string& method, std::string_view data,
                       uint64_t size);
/// For data whose size is not known in advance.
constexpr uint64_t kUnknownSize = ~uint64_t{0};

/// Whether data begin like those of zstd.
bool IsZstd(std::string_view data);

/// Decompresses a zstd file to another file. check: receives the first bytes,
/// and throws if the rest is not worth it. Throws InputError, naming `from`,
/// and Error(kOutputFailed), naming `to`.
void DecompressZstdFile(const std::string& from, const std::string& to,
                        const std::function<void(const std::string&)>& check);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_COMPRESSION_H
