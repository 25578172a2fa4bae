#include "dataset/exif_operating_point.h"

#include <libexif/exif-data.h>

#include <cstdint>
#include <memory>

#include "dataset/image_header.h"

namespace raygrid {
namespace {

// Tag of EXIF 2.31 that libexif 0.6.24 does not define.
constexpr auto kAmbientTemperature = static_cast<ExifTag>(0x9400);

struct ExifDeleter {
  void operator()(ExifData* data) const { exif_data_unref(data); }
};
using Exif = std::unique_ptr<ExifData, ExifDeleter>;

// Returns null if the file has no EXIF data.
Exif LoadExif(const std::string& name, const std::string& bytes) {
  const ImageHeader header = ParseImageHeader(name, bytes);
  if (header.exif_bytes == 0) return nullptr;
  std::string block("Exif\0\0", 6);
  block.append(bytes, header.exif_at, header.exif_bytes);
  Exif exif(exif_data_new());
  if (!exif) return nullptr;
  exif_data_unset_option(exif.get(), EXIF_DATA_OPTION_IGNORE_UNKNOWN_TAGS);
  exif_data_unset_option(exif.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_load_data(exif.get(),
                      reinterpret_cast<const unsigned char*>(block.data()),
                      static_cast<unsigned int>(block.size()));
  return exif;
}

// Returns the entry of a tag if its value is a single rational number of 8
// bytes.
const ExifEntry* FindRational(const Exif& exif, ExifTag tag,
                              ExifFormat format) {
  const ExifEntry* entry =
      exif_content_get_entry(exif->ifd[EXIF_IFD_EXIF], tag);
  if (!entry || entry->format != format || entry->components != 1 ||
      entry->size < 8)
    return nullptr;
  return entry;
}

std::optional<double> ReadLensPosition(const Exif& exif) {
  const ExifEntry* entry =
      FindRational(exif, EXIF_TAG_SUBJECT_DISTANCE, EXIF_FORMAT_RATIONAL);
  if (!entry) return std::nullopt;
  const ExifRational distance_m =
      exif_get_rational(entry->data, exif_data_get_byte_order(exif.get()));
  if (distance_m.numerator == 0) return std::nullopt;
  if (distance_m.numerator == 0xffffffff) return 0;
  // Programs that write 1 / dioptres, such as rpicam-still, write a zero
  // denominator for infinity.
  const double dioptres =
      static_cast<double>(distance_m.denominator) / distance_m.numerator;
  constexpr double kMaxValidDioptres = 100;  // 1 cm; larger values are invalid
  if (dioptres > kMaxValidDioptres) return std::nullopt;
  return dioptres;
}

std::optional<double> Temperature(const Exif& exif) {
  const ExifEntry* entry =
      FindRational(exif, kAmbientTemperature, EXIF_FORMAT_SRATIONAL);
  if (!entry) return std::nullopt;
  const ExifSRational degrees =
      exif_get_srational(entry->data, exif_data_get_byte_order(exif.get()));
  constexpr int32_t kUnknown = -1;
  if (degrees.denominator == 0 || degrees.denominator == kUnknown)
    return std::nullopt;
  return static_cast<double>(degrees.numerator) / degrees.denominator;
}

}  // namespace

std::string ExifTagName(OperatingParameter condition) {
  return condition == OperatingParameter::kLensPosition ? "SubjectDistance"
                                                        : "AmbientTemperature";
}

std::optional<double> ReadExifParameter(const std::string& name,
                                        const std::string& bytes,
                                        OperatingParameter condition) {
  const Exif exif = LoadExif(name, bytes);
  if (!exif) return std::nullopt;
  return condition == OperatingParameter::kLensPosition ? ReadLensPosition(exif)
                                                        : Temperature(exif);
}

}  // namespace raygrid
