#ifndef RAYGRID_EXCHANGE_XML_H
#define RAYGRID_EXCHANGE_XML_H

#include <map>
#include <string>
#include <vector>

namespace raygrid {

/// An element of an XML document. Its text is that between its children, too,
/// without the space around it.
struct XmlElement {
  std::string name, text;
  std::map<std::string, std::string> attributes;
  std::vector<XmlElement> children;
  int line = 0;

  /// The first child of a name; null if there is none.
  const XmlElement* Child(const std::string& child) const;
};

/// The root of a document whose type, if it names one, declares nothing. Throws
/// InputError, with the line.
XmlElement ParseXml(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_XML_H
