// The parser of .msg and .srv files. For a wrong text it reports problems that a terminal can show. For any
// other text it returns a definition, which is printed, and parsed again as the same definition.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "from_msg/idl_text.h"
#include "from_msg/layouts.h"
#include "from_msg/model_of.h"
#include "from_msg/names.h"
#include "from_msg/parse.h"
#include "from_msg/service.h"
#include "from_msg/utf8.h"
#include "tests/generators/msg/print_definition.h"

namespace {

using namespace sft::msg;

void require(bool condition) {
  if (!condition) std::abort();
}

Definition without_lines(Definition definition) {
  for (Constant& constant : definition.constants) constant.line = 0;
  for (Field& field : definition.fields) field.line = field.layout.line = field.layout.column = 0;
  return definition;
}

void check(const std::vector<Problem>& problems, std::string_view text) {
  require(!problems.empty() && problems.size() <= Limits::problems);
  const auto lines = 1 + std::ranges::count_if(text, [](char c) { return c == '\n' || c == '\r'; });
  std::uint32_t previous = 1;
  for (const Problem& problem : problems) {
    require(problem.line >= previous && problem.line <= lines);
    require(problem.text.size() < 1000 &&
            problem.text.find_first_of(std::string_view("\n\r\0\x1b", 4)) == std::string::npos);
    require(find_invalid_utf8(problem.text) == std::string::npos);
    require(problem.member.empty() || is_field_name(problem.member) || is_constant_name(problem.member));
    previous = problem.line;
  }
}

void check(const Definition& definition, std::string_view text) {
  const auto again = parse(test::print(definition), definition.type);
  require(again && without_lines(*again) == without_lines(definition));
  require(!idl_text(definition).empty());
  for (const Problem& problem : check_layouts(definition, [](const TypeName&) { return nullptr; }))
    check(std::vector<Problem>{problem}, text);
  const ModelOf model(definition, {"/root", {}});
  require(model.file().declaration_count == definition.constants.size() + 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto definition = parse(text, {"my_msgs", "Example"});
  definition ? check(*definition, text) : check(definition.error(), text);
  const auto service = parse_service(text, {"my_msgs", "Example", "srv"});
  if (!service) return check(service.error(), text), 0;
  for (const std::size_t part : {0, 1}) check((*service)[part], text);
  const ModelOf model({"my_msgs", "Example", "srv"}, *service, {"/root", {}});
  require(model.file().declaration_count ==
          (*service)[0].constants.size() + (*service)[1].constants.size() + 5);
  return 0;
}
