#include "emit.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <span>
#include <string>
#include <vector>

#include "code.h"
#include "enclosed.h"
#include "fields.h"
#include "macros.h"
#include "message.h"
#include "output.h"
#include "owned.h"
#include "paths.h"
#include "table.h"
#include "views.h"

namespace sft::idl {
namespace {

std::vector<Message> messages_of(const sft_file& file) {
  std::vector<Message> messages;
  for (const sft_declaration& declaration : std::span(file.declarations, file.declaration_count)) {
    if (declaration.kind == SFT_STRUCT) messages.push_back(make_message(file, declaration));
  }
  return messages;
}

void emit_preamble(Code& code, const sft_file& file, const Roots& roots, const std::string& folder,
                   const std::vector<Message>& messages) {
  code.line("// Generated from {}. Do not edit.", roots.relative(file.path).generic_string());
  code.line("#pragma once");
  code.blank();
  code.line("#include \"sft/detail/generated.h\"");
  const auto has_cells = [](const Message& message) {
    return std::ranges::any_of(message.fields, is_reservable);
  };
  if (std::ranges::any_of(messages, has_cells)) code.line("#include \"sft/cells.h\"");
  if (std::ranges::any_of(messages, is_cloud)) code.line("#include \"sft/points.h\"");
  for (const char* included : std::span(file.includes, file.include_count)) {
    code.line("#include <{}{}>", folder, roots.relative(included).replace_extension(".hpp").generic_string());
  }
  code.blank();
}

/// Returns the text between the includes and the end of the header.
std::string definitions_text(const sft_file& file, const std::vector<Message>& messages) {
  Code code;
  emit_owned(code, file, messages);
  for (const sft_declaration& declaration : std::span(file.declarations, file.declaration_count)) {
    if (declaration.kind == SFT_ENUMERATION || declaration.kind == SFT_BITMASK)
      emit_enum_table(code, file, declaration);
  }
  for (const Message& message : messages) emit_table(code, message);
  for (const Message& message : messages) emit_fields(code, message);
  for (const Message& message : messages) emit_view(code, message);
  for (const Message& message : messages) emit_loan_view(code, message);
  return code.text();
}

std::string header_text(const sft_file& file, const Roots& roots, const std::string& folder) {
  const std::vector<Message> messages = messages_of(file);
  const std::string definitions = definitions_text(file, messages);
  const std::vector<std::string_view> macros = foreign_macros_in(definitions);
  Code code;
  emit_preamble(code, file, roots, folder, messages);
  for (const std::string_view name : macros) code.line("#pragma push_macro(\"{0}\")\n#undef {0}", name);
  if (!macros.empty()) code.blank();
  code.append(definitions);
  if (!macros.empty()) code.blank();
  for (const std::string_view name : macros) code.line("#pragma pop_macro(\"{}\")", name);
  return code.text();
}

/// Escapes a path for a make rule.
std::string make_path(std::string_view path) {
  std::string result;
  for (const char c : path) {
    if (c == ' ' || c == '#' || c == '\\') result += '\\';
    if (c == '$') result += '$';
    result += c;
  }
  return result;
}

std::string make_rule(const sft_file& file, const char* header) {
  std::string rule = make_path(header) + ":";
  for (const char* source : std::span(file.sources, file.source_count)) rule += " \\\n  " + make_path(source);
  return rule + "\n";
}

}  // namespace
}  // namespace sft::idl

bool sft_emit(const sft_file* file, const sft_output* output) try {
  using namespace sft::idl;
  const Roots roots(output->roots, output->base_dir, file->path);
  const Enclosed enclosed(*file, output->outer_namespace);
  const std::string header =
      header_text(enclosed.file(), roots, folder_of_namespace(output->outer_namespace));
  const std::string_view dependencies = output->dependencies;
  if (!dependencies.empty()) write_file(dependencies, make_rule(*file, output->header));
  write_file(output->header, header);
  return true;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s: %s\n", file->path, error.what());
  return false;
}
