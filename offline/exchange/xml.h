#ifndef RAYGRID_EXCHANGE_XML_H
#define RAYGRID_EXCHANGE_XML_H

#include <map>
#include <string>
#include <vector>

namespace raygrid {

/// An XML element. Its text includes the text between its children, without
/// surrounding white space.
struct XmlElement {
  std::string name, text;
  std::map<std::string, std::string> attributes;
  std::vector<XmlElement> children;
  int line = 0;

  /// Returns the first child with this name; null if there is none.
  const XmlElement* Child(const std::string& child) const;
};

/// Parses a document and returns its root. Document types with declarations are
/// rejected. Throws InputError with the line.
XmlElement ParseXml(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_XML_H
