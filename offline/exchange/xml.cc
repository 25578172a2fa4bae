#include "exchange/xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

constexpr char kSpace[] = " \t\r\n";

std::string Trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(kSpace);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

class XmlParser {
 public:
  explicit XmlParser(const std::string& text) : text_(text) {}

  XmlElement Document() {
    SkipOthers();
    if (!Follows("<")) Fail("no element");
    XmlElement root = Element(0);
    SkipOthers();
    if (at_ != text_.size()) Fail("more behind the end of the root element");
    return root;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    const size_t end = std::min(at_, text_.size());
    throw InputError(fmt::format(
        "line {}: not XML: {}",
        1 + std::count(text_.begin(),
                       text_.begin() + static_cast<std::ptrdiff_t>(end), '\n'),
        what));
  }

  bool Follows(const std::string& word) const {
    return text_.compare(at_, word.size(), word) == 0;
  }
  bool Take(const std::string& word) {
    if (!Follows(word)) return false;
    at_ += word.size();
    return true;
  }
  void SkipSpace() {
    at_ = std::min(text_.find_first_not_of(kSpace, at_), text_.size());
  }
  // All up to a word, which is skipped, too.
  std::string TakeUpTo(const std::string& word) {
    const size_t end = text_.find(word, at_);
    if (end == std::string::npos) Fail("'" + word + "' is missing");
    const std::string taken = text_.substr(at_, end - at_);
    at_ = end + word.size();
    return taken;
  }
  bool SkipComment() {
    if (Take("<!--")) {
      TakeUpTo("-->");
      return true;
    }
    if (!Take("<?")) return false;
    TakeUpTo("?>");
    return true;
  }
  // Comments and instructions around the root.
  void SkipOthers() {
    do SkipSpace();
    while (SkipComment());
  }

  std::string Name() {
    const size_t first = at_;
    while (at_ < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[at_])) ||
            std::string("_:.-").find(text_[at_]) != std::string::npos))
      ++at_;
    if (at_ == first) Fail("a name is missing");
    return text_.substr(first, at_ - first);
  }

  std::string Unescaped(const std::string& text) const {
    std::string plain;
    for (size_t k = 0; k < text.size(); ++k) {
      if (text[k] != '&') {
        plain += text[k];
        continue;
      }
      const size_t end = text.find(';', k);
      const std::string name =
          end == std::string::npos ? "" : text.substr(k + 1, end - k - 1);
      const std::map<std::string, char> known = {{"lt", '<'},
                                                 {"gt", '>'},
                                                 {"amp", '&'},
                                                 {"quot", '"'},
                                                 {"apos", '\''}};
      const auto found = known.find(name);
      if (found == known.end()) Fail("'&' that begins no known entity");
      plain += found->second;
      k = end;
    }
    return plain;
  }

  void Attributes(XmlElement* element) {
    while (true) {
      SkipSpace();
      if (at_ >= text_.size()) Fail("ends within '<" + element->name + "'");
      if (Follows(">") || Follows("/>")) return;
      const std::string name = Name();
      SkipSpace();
      if (!Take("=")) Fail("'=' is missing");
      SkipSpace();
      const std::string quote = Follows("'") ? "'" : "\"";
      if (!Take(quote)) Fail("a quote is missing");
      if (!element->attributes.emplace(name, Unescaped(TakeUpTo(quote))).second)
        Fail("the attribute '" + name + "' stands twice");
    }
  }

  XmlElement Element(int depth) {
    constexpr int kDeepest = 100;
    if (depth > kDeepest) Fail("elements are too deep");
    XmlElement element;
    element.line = static_cast<int>(
        1 + std::count(text_.begin(),
                       text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n'));
    Take("<");
    element.name = Name();
    Attributes(&element);
    if (Take("/>")) return element;
    Take(">");
    while (!Take("</" + element.name)) {
      if (at_ >= text_.size()) Fail("'</" + element.name + ">' is missing");
      if (SkipComment()) continue;
      if (Follows("</")) Fail("'</" + element.name + ">' is missing");
      if (Follows("<")) {
        element.children.push_back(Element(depth + 1));
      } else {
        const size_t end = std::min(text_.find('<', at_), text_.size());
        element.text += Unescaped(text_.substr(at_, end - at_));
        at_ = end;
      }
    }
    SkipSpace();
    if (!Take(">")) Fail("'>' is missing");
    element.text = Trimmed(element.text);
    return element;
  }

  const std::string& text_;
  size_t at_ = 0;
};

}  // namespace

const XmlElement* XmlElement::Child(const std::string& child) const {
  for (const XmlElement& element : children)
    if (element.name == child) return &element;
  return nullptr;
}

XmlElement ParseXml(const std::string& text) {
  if (FindNoUtf8(text) != std::string::npos)
    throw InputError("not a text file");
  return XmlParser(text).Document();
}

}  // namespace raygrid
