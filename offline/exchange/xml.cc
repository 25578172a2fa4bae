#include "exchange/xml.h"

#include <expat.h>
#include <fmt/format.h>

#include <limits>
#include <memory>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

std::string TrimWhitespace(const std::string& text) {
  constexpr char kWhitespace[] = " \t\r\n";
  const size_t first = text.find_first_not_of(kWhitespace);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(kWhitespace) - first + 1);
}

// Builds the tree from expat's events.
class XmlTree {
 public:
  XmlTree() : parser_(XML_ParserCreate("UTF-8"), XML_ParserFree) {
    if (!parser_) throw std::bad_alloc();
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), Begin, End);
    XML_SetCharacterDataHandler(parser_.get(), AddText);
    XML_SetStartDoctypeDeclHandler(parser_.get(), RefuseType);
  }

  XmlElement Parse(const std::string& text) {
    if (text.size() > std::numeric_limits<int>::max())
      throw InputError("not XML: larger than 2 GiB");
    if (XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()),
                  XML_TRUE) != XML_STATUS_OK)
      throw InputError(fmt::format("line {}: not XML: {}",
                                   XML_GetCurrentLineNumber(parser_.get()),
                                   GetErrorText()));
    return std::move(root_);
  }

 private:
  // expat's message for a document that ends within an element is the same as
  // for a document without elements, so they are distinguished here.
  std::string GetErrorText() const {
    if (!error_text_.empty()) return error_text_;
    const XML_Error error = XML_GetErrorCode(parser_.get());
    if (error == XML_ERROR_NO_ELEMENTS && !open_.empty())
      return fmt::format("'</{}>' is missing", Printable(open_.back()->name));
    return XML_ErrorString(error);
  }

  void SetError(const char* reason) {
    error_text_ = reason;
    XML_StopParser(parser_.get(), XML_FALSE);
  }

  static void Begin(void* data, const XML_Char* name,
                    const XML_Char** attributes) {
    constexpr size_t kDeepest = 100;
    XmlTree& tree = *static_cast<XmlTree*>(data);
    if (tree.open_.size() > kDeepest) {
      tree.SetError("elements are nested too deeply");
      return;
    }
    // Pointers to open elements remain valid: siblings are added only after an
    // element is closed.
    XmlElement& element = tree.open_.empty()
                              ? tree.root_
                              : tree.open_.back()->children.emplace_back();
    element.name = name;
    element.line =
        static_cast<int>(XML_GetCurrentLineNumber(tree.parser_.get()));
    for (; *attributes; attributes += 2)
      element.attributes[attributes[0]] = attributes[1];
    tree.open_.push_back(&element);
  }

  static void End(void* data, const XML_Char* /*name*/) {
    XmlTree& tree = *static_cast<XmlTree*>(data);
    tree.open_.back()->text = TrimWhitespace(tree.open_.back()->text);
    tree.open_.pop_back();
  }

  static void AddText(void* data, const XML_Char* text, int length) {
    XmlTree& tree = *static_cast<XmlTree*>(data);
    if (!tree.open_.empty()) tree.open_.back()->text.append(text, length);
  }

  static void RefuseType(void* data, const XML_Char* /*name*/,
                         const XML_Char* /*system_id*/,
                         const XML_Char* /*public_id*/, int has_subset) {
    if (has_subset)
      static_cast<XmlTree*>(data)->SetError(
          "document type declarations are not supported");
  }

  std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_;
  XmlElement root_;
  std::vector<XmlElement*> open_;
  std::string error_text_;
};

}  // namespace

const XmlElement* XmlElement::Child(const std::string& child) const {
  for (const XmlElement& element : children)
    if (element.name == child) return &element;
  return nullptr;
}

XmlElement ParseXml(const std::string& text) {
  RequireSmallTree("", text, kXmlMarks);
  if (FindInvalidUtf8(text) != std::string::npos)
    throw InputError("not UTF-8 text");
  return XmlTree().Parse(text);
}

}  // namespace raygrid
