#include "help_formatter.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

namespace raygrid {
namespace {

constexpr size_t kLineWidth = 80, kOptionColumn = 26, kCommandColumn = 14;

// Returns the number of Unicode code points of a UTF-8 text.
size_t DisplayWidth(const std::string& text) {
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(),
                    [](char byte) { return (byte & 0xc0) != 0x80; }));
}

// Returns a name and its description, which starts at a column, or in the next
// line if the name is too long.
std::string Entry(const std::string& name, const std::string& description,
                  size_t column) {
  std::string entry = "  " + name;
  const std::string lines = WrapText(description, column);
  const size_t width = DisplayWidth(entry);
  if (width + 2 > column) return entry + "\n" + lines;
  return entry + lines.substr(width);
}

bool IsCommon(const CLI::Option* option) {
  for (const char* name :
       {"--threads", "--seed", "--quiet", "--json", "--help"})
    if (option->check_lname(name + 2)) return true;
  return false;
}

// Returns the value's placeholder: the choices of CLI::IsMember, "TEXT:{a,b}",
// as "a|b"; N for integers, X for other numbers, otherwise VALUE.
std::string ValueName(const CLI::Option* option) {
  if (!option->get_option_text().empty()) return option->get_option_text();
  const std::string type = option->get_type_name();
  const size_t open = type.find('{'), close = type.find('}');
  if (open != std::string::npos && close != std::string::npos) {
    std::string words = type.substr(open + 1, close - open - 1);
    std::replace(words.begin(), words.end(), ',', '|');
    return words;
  }
  if (type.rfind("INT", 0) == 0 || type.rfind("UINT", 0) == 0) return "N";
  if (type.rfind("FLOAT", 0) == 0) return "X";
  return type.rfind("TEXT", 0) == 0 ? "VALUE" : type;
}

std::string OptionEntry(const CLI::Option* option) {
  std::string name = option->get_name(option->get_positional(), true);
  const bool has_value = option->get_type_size() != 0;
  if (option->get_positional()) {
    std::transform(name.begin(), name.end(), name.begin(), ::toupper);
    if (option->get_expected_max() > 1) name += "...";
  } else if (has_value) {
    name += " " + ValueName(option);
  }
  std::string description = option->get_description();
  if (has_value && !option->get_default_str().empty())
    description += " (default: " + option->get_default_str() + ")";
  else if (option->get_required() && !option->get_positional())
    description += " (required)";
  return Entry(name, description, kOptionColumn);
}

std::string Usage(const CLI::App* app, const std::string& name) {
  std::string usage = "Usage: " + name + " [OPTIONS]";
  for (const CLI::Option* option : app->get_options())
    if (option->get_positional()) {
      std::string argument = option->get_name(true, false);
      std::transform(argument.begin(), argument.end(), argument.begin(),
                     ::toupper);
      if (option->get_expected_max() > 1) argument += "...";
      usage += option->get_required() ? " " + argument : " [" + argument + "]";
    }
  if (!app->get_subcommands({}).empty()) usage += " COMMAND";
  return usage + "\n";
}

std::string Arguments(const CLI::App* app) {
  std::string lines;
  for (const CLI::Option* option : app->get_options())
    if (option->get_positional()) lines += OptionEntry(option);
  return lines.empty() ? lines : "\nArguments:\n" + lines;
}

std::string OptionGroup(const CLI::App* app, const std::string& group) {
  std::string lines, common;
  for (const CLI::Option* option : app->get_options()) {
    if (option->get_positional() || option->get_group() != group) continue;
    (IsCommon(option) ? common : lines) += OptionEntry(option);
  }
  lines += common;
  return lines.empty() ? lines : "\n" + group + ":\n" + lines;
}

std::string OptionGroups(const CLI::App* app) {
  std::vector<std::string> groups = {help_group::kInput, help_group::kBags,
                                     help_group::kModel, help_group::kTarget};
  const std::vector<std::string> last = {help_group::kView, help_group::kOutput,
                                         help_group::kAdvanced};
  const auto contains = [](const std::vector<std::string>& names,
                           const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  // The option groups of single commands are printed between these.
  for (const std::string& group : app->get_groups())
    if (!group.empty() && !contains(groups, group) && !contains(last, group))
      groups.push_back(group);
  groups.insert(groups.end(), last.begin(), last.end());
  std::string text;
  for (const std::string& group : groups) text += OptionGroup(app, group);
  return text;
}

// Returns the commands by group, both in the order in which they were added.
std::string Commands(const CLI::App* app) {
  std::vector<std::string> groups;
  for (const CLI::App* command : app->get_subcommands({}))
    if (std::find(groups.begin(), groups.end(), command->get_group()) ==
        groups.end())
      groups.push_back(command->get_group());
  std::string text;
  for (const std::string& group : groups) {
    text += "\n" + group + ":\n";
    for (const CLI::App* command : app->get_subcommands({}))
      if (command->get_group() == group)
        text += Entry(command->get_name(), command->get_description(),
                      kCommandColumn);
  }
  return text;
}

}  // namespace

std::string WrapText(const std::string& text, size_t indent) {
  const std::string margin(indent, ' ');
  std::istringstream words(text);
  std::string lines, line, word;
  while (words >> word) {
    const bool fits =
        line.empty() ||
        indent + DisplayWidth(line) + 1 + DisplayWidth(word) <= kLineWidth;
    if (!fits) {
      lines += margin + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return lines + margin + line + "\n";
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name,
                                     CLI::AppFormatMode) const {
  std::string help = WrapText(app->get_description(), 0) + "\n";
  help += Usage(app, name) + Arguments(app) + Commands(app) + OptionGroups(app);
  const std::string footer = app->get_footer();
  return footer.empty() ? help : help + "\n" + footer + "\n";
}

void BeginGroup(CLI::App* command, const char* group) {
  command->option_defaults()->group(group);
}

}  // namespace raygrid
