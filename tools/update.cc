#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "help_formatter.h"
#include "json_output.h"
#include "packing/blob_camera.h"
#include "packing/slot_file.h"

namespace raygrid {
namespace {

constexpr uint64_t kDefaultSlotSize = 64 << 10;
constexpr uint64_t kMaxSlotSize = 1 << 30;

struct UpdateArguments {
  std::string blob, slots;
  std::optional<uint64_t> slot_size;
  bool is_new = false;
};

// Returns the bytes of a complete blob, without trailing data.
std::string ReadBlob(const std::string& path) {
  std::string bytes = ReadFile(path);
  bytes.resize(BlobCamera(path, bytes).blob().size);
  return bytes;
}

// A file or block device that is locked and updated in place.
class SlotStore {
 public:
  explicit SlotStore(const std::string& path)
      : path_(path),
        file_(open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK)) {
    struct stat status = {};
    if (file_ < 0 || fstat(file_, &status) != 0) ThrowWriteError(path_, errno);
    if (!S_ISREG(status.st_mode) && !S_ISBLK(status.st_mode)) {
      close(file_);
      throw Error(ExitCode::kOutputFailed,
                  path_ +
                      ": not a file or block device; for MTD use "
                      "/dev/mtdblock, or flash the file written by update");
    }
    is_device_ = S_ISBLK(status.st_mode);
    while (flock(file_, LOCK_EX) != 0 && errno == EINTR) {
    }
  }
  ~SlotStore() { close(file_); }
  SlotStore(const SlotStore&) = delete;
  SlotStore& operator=(const SlotStore&) = delete;

  bool is_device() const { return is_device_; }

  uint64_t Size() const {
    const off_t size = lseek(file_, 0, SEEK_END);
    if (size < 0) ThrowWriteError(path_, errno);
    return static_cast<uint64_t>(size);
  }

  std::string Read(uint64_t num_bytes) const {
    std::string bytes(num_bytes, '\0');
    for (size_t done = 0; done < bytes.size();) {
      const ssize_t size = pread(file_, bytes.data() + done,
                                 bytes.size() - done, static_cast<off_t>(done));
      if (size < 0 && errno == EINTR) continue;
      if (size <= 0)
        throw InputError(
            fmt::format("{}: cannot be read ({})", path_,
                        size == 0 ? "it was truncated" : std::strerror(errno)));
      done += static_cast<size_t>(size);
    }
    return bytes;
  }

  // Data is on disk when the function returns.
  void Write(const SlotWrite& write) const {
    for (size_t done = 0; done < write.bytes.size();) {
      const ssize_t size =
          pwrite(file_, write.bytes.data() + done, write.bytes.size() - done,
                 static_cast<off_t>(write.offset + done));
      if (size < 0 && errno == EINTR) continue;
      if (size < 0) ThrowWriteError(path_, errno);
      done += static_cast<size_t>(size);
    }
    if (fsync(file_) != 0) ThrowWriteError(path_, errno);
  }

 private:
  std::string path_;
  int file_;
  bool is_device_ = false;
};

void RequireSlotSize(uint64_t slot_size, const UpdateArguments& arguments,
                     const std::string& blob) {
  if (slot_size % 4 != 0 || slot_size > kMaxSlotSize)
    throw Error(ExitCode::kUsage,
                fmt::format("--slot-size {}: must be a multiple of 4 bytes, at "
                            "most 1 GiB; use a multiple of the erase size",
                            slot_size));
  if (SlotSizeFor(blob) > slot_size)
    throw Error(
        ExitCode::kOutputFailed,
        fmt::format("{}: requires {} bytes including its header, but a slot "
                    "has {}; reduce the blob, or use a larger --slot-size",
                    arguments.blob, SlotSizeFor(blob), slot_size));
}

// Returns the size of the existing slots.
uint64_t GetSlotsSize(const SlotStore& store,
                      const UpdateArguments& arguments) {
  const uint64_t size = store.Size();
  if (store.is_device() && !arguments.slot_size)
    throw Error(
        ExitCode::kUsage,
        arguments.slots +
            ": is a block device; specify the slot size with --slot-size");
  const uint64_t slot_size = arguments.slot_size.value_or(size / 2);
  if (store.is_device() ? 2 * slot_size > size
                        : 2 * slot_size != size || size % 8 != 0)
    throw InputError(
        fmt::format("{}: its size is {} bytes, but it must hold two slots of "
                    "{}; use another file",
                    arguments.slots, size,
                    arguments.slot_size ? fmt::format("{} bytes", slot_size)
                                        : "equal size, a multiple of 4 bytes"));
  return slot_size;
}

void RequireSlots(const BlobSlots& read, const UpdateArguments& arguments) {
  const auto& [first, second] = read.slots;
  const bool is_erased = first.is_erased && second.is_erased;
  if (!first.is_whole && !second.is_whole && !is_erased && !arguments.is_new)
    throw InputError(arguments.slots +
                     ": contains no valid blob and is not erased; overwrite it "
                     "with --initialize");
}

void PrintUpdate(const UpdateArguments& arguments, const CommonOptions& common,
                 uint32_t index, uint32_t sequence, uint64_t num_bytes,
                 uint64_t slot_size, bool is_written) {
  if (common.json)
    PrintCommandJson({{"slot", index},
                      {"sequence", sequence},
                      {"bytes", num_bytes},
                      {"slot_size", slot_size},
                      {"written", is_written}});
  else
    fmt::print(
        "{}: slot {} {}, sequence {}, {} of {} bytes\n", arguments.slots, index,
        is_written ? "written" : "already contains this blob (latest version)",
        sequence, num_bytes, slot_size - SlotSizeFor(""));
}

void MakeSlots(const UpdateArguments& arguments, const CommonOptions& common,
               const std::string& blob) {
  const uint64_t slot_size = arguments.slot_size.value_or(kDefaultSlotSize);
  RequireSlotSize(slot_size, arguments, blob);
  std::string bytes(2 * slot_size, '\xff');
  const SlotUpdate update = PlanSlotUpdate({}, slot_size, blob);
  for (const SlotWrite& write : update.writes)
    bytes.replace(write.offset, write.bytes.size(), write.bytes);
  WriteFile(arguments.slots, bytes);
  PrintUpdate(arguments, common, update.index, update.sequence, blob.size(),
              slot_size, true);
}

void UpdateSlots(const UpdateArguments& arguments, const CommonOptions& common,
                 const std::string& blob) {
  const SlotStore store(arguments.slots);
  const uint64_t slot_size = GetSlotsSize(store, arguments);
  RequireSlotSize(slot_size, arguments, blob);
  const std::string bytes = store.Read(2 * slot_size);
  if (const auto place = FindMisplacedSlot(bytes); place && !arguments.is_new)
    throw InputError(
        fmt::format("{}: found a slot at byte {}, but the second slot should "
                    "begin at {}; use an exact copy of both slots",
                    arguments.slots, *place, slot_size));
  const BlobSlots read = ReadSlots(bytes);
  RequireSlots(read, arguments);
  if (read.newest && read.slots[*read.newest].blob == blob) {
    PrintUpdate(arguments, common, *read.newest,
                read.slots[*read.newest].sequence, blob.size(), slot_size,
                false);
    return;
  }
  const SlotUpdate update = PlanSlotUpdate(read, slot_size, blob);
  for (const SlotWrite& write : update.writes) store.Write(write);
  PrintUpdate(arguments, common, update.index, update.sequence, blob.size(),
              slot_size, true);
}

void RunUpdate(const UpdateArguments& arguments, const CommonOptions& common) {
  const std::string blob = ReadBlob(arguments.blob);
  RequireNoInputReplaced({arguments.blob}, {arguments.slots});
  struct stat status = {};
  if (stat(arguments.slots.c_str(), &status) != 0 && errno == ENOENT)
    MakeSlots(arguments, common, blob);
  else
    UpdateSlots(arguments, common, blob);
}

}  // namespace

void AddUpdate(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "update", "Write a blob to the older of two flash slots.",
      "raygrid update front.raygrid --slots slots.bin --slot-size 64K", common);
  auto arguments = std::make_shared<UpdateArguments>();
  command->add_option("blob", arguments->blob, "blob written by raygrid pack")
      ->required();
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("--slots", arguments->slots,
                   "block device or file that holds both slots; a file is "
                   "created if missing")
      ->option_text("PATH")
      ->required();
  command
      ->add_option("--slot-size", arguments->slot_size,
                   "size of a slot, such as 64K or 1M; a multiple of the erase "
                   "size of the flash (default: half of the file, or 64K)")
      ->transform(CLI::AsSizeValue(false))
      ->option_text("BYTES");
  command->add_flag("--initialize", arguments->is_new,
                    "overwrite a file or device that does not contain slots");
  command->callback([arguments, common] { RunUpdate(*arguments, *common); });
}

}  // namespace raygrid
