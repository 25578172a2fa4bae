#include "report/html.h"

#include <fmt/format.h>

#include <cmath>

#include "report/page_files.h"

namespace raygrid {
namespace {

std::string Ticks(const std::vector<std::string>& ticks) {
  std::string html;
  for (const std::string& tick : ticks)
    html += fmt::format("<span>{}</span>", tick);
  return html;
}

}  // namespace

std::string EscapeHtml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '&')
      escaped += "&amp;";
    else if (c == '"')
      escaped += "&quot;";
    else if (c == '\'')
      escaped += "&#39;";
    else
      escaped += c;
  }
  return escaped;
}

std::string Base64(const std::string& bytes) {
  static const char digits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() / 3 * 4 + 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k)
      group = group << 8 |
              (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string MakeHtmlTable(const HtmlRow& head,
                          const std::vector<HtmlRow>& rows) {
  std::string html = "<div class=\"scroll\"><table>\n";
  if (!head.empty()) {
    html += "<tr>";
    for (const std::string& cell : head) html += "<th>" + cell + "</th>";
    html += "</tr>\n";
  }
  for (const HtmlRow& row : rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += "<td>" + cell + "</td>";
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

HtmlImageAxes AreaAxes(const Area& area) {
  const auto ticks = [](double a, double b) -> std::vector<std::string> {
    return {fmt::format("{}", std::lround(a)),
            fmt::format("{}", std::lround((a + b) / 2)),
            fmt::format("{}", std::lround(b))};
  };
  return {"x, px", "y, px", ticks(area.x0, area.x1), ticks(area.y0, area.y1)};
}

std::string MakeHtmlColorBar(const ColorBar& bar) {
  return fmt::format(
      "<div class=\"scale\"><span>{}</span><span class=\"bar\" "
      "style=\"background:{}\"></span><span>{}</span><em>{}</em></div>",
      bar.low, CssGradient(bar.scale), bar.high, bar.label);
}

std::string MakeHtmlImage(const Image& picture, const std::string& alt) {
  return fmt::format(
      "<img alt=\"{}\" width=\"{}\" height=\"{}\" "
      "src=\"data:image/png;base64,{}\">",
      EscapeHtml(alt), picture.size.width, picture.size.height,
      Base64(EncodePng(picture)));
}

std::string EmbedHtmlImage(const Image& picture, const std::string& caption,
                           const HtmlImageAxes& axes, const std::string& legend,
                           const std::string& view) {
  return fmt::format(
      "<figure><figcaption>{0}</figcaption><div class=\"plot\">"
      "<div class=\"y-label\"><span>{1}</span></div>"
      "<div class=\"y-ticks\">{2}</div><div class=\"view\" "
      "data-view=\"{3}\">{4}</div><div class=\"x-ticks\">{5}</div>"
      "<div class=\"x-label\">{6}</div></div>{7}</figure>\n",
      caption, axes.y_label, Ticks(axes.y_ticks), view,
      MakeHtmlImage(picture, caption), Ticks(axes.x_ticks), axes.x_label,
      legend);
}

std::string PageStart(const std::string& heading, const std::string& title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}</style></head>\n<body>\n"
      "<h1>{}</h1>\n",
      title, kReportStyle, heading);
}

std::string PageEnd(const std::string& data_json, bool has_trial) {
  std::string safe;  // escaped such that no tag ends the script
  for (const char c : data_json)
    safe += c == '<' ? "\\u003c" : std::string(1, c);
  return "<script id=\"data\" type=\"application/json\">" + safe +
         "</script>\n<script>" + kChartLibrary + "</script>\n<script>" +
         kReportScript + "</script>\n" +
         (has_trial ? std::string("<script type=\"module\">") +
                          kRuntimeLibrary + kTrialScript + "</script>\n"
                    : "") +
         "</body></html>\n";
}

}  // namespace raygrid
