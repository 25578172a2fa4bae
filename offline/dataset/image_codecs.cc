#include "dataset/image_codecs.h"

#include <dlfcn.h>

#include <filesystem>

#include "dataset/error.h"
#include "dataset/image_codecs_module.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// The folder of the program, or of the Python extension, that this is in.
fs::path OwnFolder() {
  static const char in_this_object = 0;
  Dl_info object;
  std::error_code error;
  if (dladdr(&in_this_object, &object) == 0) return {};
  // A program's name is as it was called: found in the PATH, it has no folder.
  const std::string name = object.dli_fname;
  const bool has_folder = name.find('/') != std::string::npos;
  return fs::canonical(has_folder ? name : "/proc/self/exe", error)
      .parent_path();
}

void* OpenModule() {
  const fs::path folder = OwnFolder();
  std::error_code error;
  for (const char* modules :
       {"../lib/raygrid",       // from bin/
        "../../lib/raygrid",    // from python/raygrid/ of a build
        "../../../raygrid"}) {  // from lib/python3/dist-packages/raygrid/
    const fs::path path = folder / modules / "raygrid_image_codecs.so";
    if (!fs::exists(path, error)) continue;
    if (void* module = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL))
      return module;
    throw InputError(std::string(dlerror()) +
                     ": cannot load the image codecs; reinstall raygrid");
  }
  throw InputError((folder / "../lib/raygrid/raygrid_image_codecs.so")
                       .lexically_normal()
                       .string() +
                   ": missing image codecs; reinstall raygrid");
}

const ImageCodecs& Loaded() {
  static const ImageCodecs* codecs = [] {
    void* entry = dlsym(OpenModule(), kImageCodecsEntry);
    if (!entry)
      throw InputError(
          "raygrid_image_codecs.so: version mismatch; reinstall raygrid");
    return reinterpret_cast<const ImageCodecs* (*)()>(entry)();
  }();
  return *codecs;
}

}  // namespace

void LoadImageCodecs() { Loaded(); }

cv::Mat DecodeImage(const std::string& bytes, int flags) {
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U,
                        const_cast<char*>(bytes.data()));
  return Loaded().decode(encoded, flags);
}

std::string EncodeImage(const char* extension, const cv::Mat& pixels,
                        const std::vector<int>& parameters) {
  return Loaded().encode(extension, pixels, parameters);
}

}  // namespace raygrid
