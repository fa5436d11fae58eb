#include "tools/sft/help_format.h"

#include <sstream>

#include "tools/terminal/columns.h"

namespace sft::tool {

namespace {

constexpr std::size_t columns = 80;

}  // namespace

std::string HelpFormat::make_option_desc(const CLI::Option* option) const {
  return described(option->get_description());
}

std::string HelpFormat::make_subcommand(const CLI::App* subcommand) const {
  std::ostringstream out;
  CLI::detail::format_help(out, subcommand->get_display_name(true), described(subcommand->get_description()),
                           get_column_width());
  return out.str();
}

std::string HelpFormat::make_description(const CLI::App* app) const {
  return wrapped(CLI::Formatter::make_description(app), columns);
}

/// The result has no indentation, because CLI11 indents each of its lines.
std::string HelpFormat::described(const std::string& text) const {
  return wrapped(text, columns - get_column_width());
}

}  // namespace sft::tool
