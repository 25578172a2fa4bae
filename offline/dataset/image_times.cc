#include "dataset/image_times.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/csv.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"

namespace raygrid {

ImageTimes ParseImageTimes(const std::string& path, const std::string& text) {
  // Minimum frame interval, of the fastest cameras.
  constexpr double kMinIntervalS = 1e-6;
  CsvReader table(path, text, {"image", "time_s"});
  table.LimitRows(kMaxTableImages);
  ImageTimes times;
  std::map<double, std::string> images;
  while (table.Next()) {
    const std::string& image = table.Text("image");
    const double time_s = table.Number("time_s");
    if (!times.insert({image, time_s}).second)
      throw InputError(fmt::format("{}: duplicate image {}", table.Place(),
                                   Printable(image)));
    const auto next = images.lower_bound(time_s - kMinIntervalS);
    if (next != images.end() && next->first <= time_s + kMinIntervalS)
      throw InputError(fmt::format(
          "{}: {} and {} have the same timestamp; timestamps must be unique, "
          "with a resolution of 0.1 ms or better",
          table.Place(), Printable(image), Printable(next->second)));
    images[time_s] = image;
  }
  if (times.empty()) throw InputError(path + ": contains no images");
  return times;
}

ImageTimes ReadImageTimes(const std::string& path) {
  return ParseImageTimes(path, ReadFile(path));
}

std::string FormatImageTimes(const ImageTimes& times) {
  std::string text = "image,time_s\n";
  for (const auto& [image, time_s] : times)
    text += fmt::format("{},{}\n", CsvField(image), time_s);
  return text;
}

}  // namespace raygrid
