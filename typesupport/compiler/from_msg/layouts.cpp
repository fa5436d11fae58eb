#include "from_msg/layouts.h"

#include <deque>
#include <utility>

#include "layout/rule.h"

namespace sft::msg {

namespace {

static_assert(static_cast<int>(SFT_STRUCTURE) == static_cast<int>(detail::Kind::structure));

class SeenDefinitions : public layout::SeenTypes {
 public:
  explicit SeenDefinitions(const FindDefinition& find) : find_(find) {}

  std::optional<layout::SeenMember> member(const void* type, std::size_t i) const override {
    const auto& fields = static_cast<const Definition*>(type)->fields;
    if (i >= fields.size()) return {};
    const Type& of_field = fields[i].type;
    layout::SeenMember seen{fields[i].name, static_cast<detail::Kind>(of_field.kind), detail::Shape::single};
    if (of_field.is_sequence) seen.shape = detail::Shape::sequence;
    if (of_field.array_size != 0) seen.shape = detail::Shape::array;
    if (seen.kind == detail::Kind::structure) seen.type = find_(of_field.nested);
    return seen;
  }

 private:
  const FindDefinition& find_;
};

}  // namespace

std::vector<Problem> check_layouts(const Definition& definition, const FindDefinition& find) {
  std::deque<layout::Rule> read;
  std::vector<layout::RuleOfMember> rules;
  for (std::size_t i = 0; i < definition.fields.size(); ++i) {
    const Field& field = definition.fields[i];
    if (!field.layout.text.empty())
      rules.push_back({i, &read.emplace_back(layout::read_rule(field.layout.text).value())});
  }
  auto fault = rules.empty() ? std::nullopt : layout::check_rules(SeenDefinitions(find), &definition, rules);
  if (!fault) return {};
  const Field& field = definition.fields[fault->member];
  return {{field.layout.line, field.name, std::move(fault->text),
           field.layout.column + static_cast<std::uint32_t>(fault->at)}};
}

std::string layout_text(const Field& field) {
  return field.layout.text.empty() ? "" : layout::read_rule(field.layout.text).value().text();
}

}  // namespace sft::msg
