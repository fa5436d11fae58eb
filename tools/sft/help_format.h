// Formats the help of CLI11 in lines that fit a terminal of 80 columns.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace sft::tool {

class HelpFormat : public CLI::Formatter {
 public:
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_subcommand(const CLI::App* subcommand) const override;
  std::string make_description(const CLI::App* app) const override;

 private:
  /// Breaks the text of an option or subcommand into lines that fit to the right of the column of names.
  std::string described(const std::string& text) const;
};

}  // namespace sft::tool
