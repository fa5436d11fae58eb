#include "layout/check.h"

#include <algorithm>
#include <cstring>
#include <deque>

#include "layout/rule.h"

namespace {

using namespace sft::layout;

static_assert(static_cast<int>(SFT_STRUCTURE) == static_cast<int>(sft::detail::Kind::structure));
static_assert(static_cast<int>(SFT_SEQUENCE) == static_cast<int>(sft::detail::Shape::sequence));

class SeenByC : public SeenTypes {
 public:
  explicit SeenByC(sft_see see) : see_(see) {}

  std::optional<SeenMember> member(const void* type, std::size_t i) const override {
    const sft_seen seen = see_(type, i);
    if (seen.name == nullptr) return {};
    return SeenMember{seen.name, static_cast<sft::detail::Kind>(seen.kind),
                      static_cast<sft::detail::Shape>(seen.shape), seen.type};
  }

 private:
  sft_see see_;
};

void say(const Fault& what, std::size_t rule, sft_rule_fault* fault) {
  fault->rule = rule;
  fault->at = what.at;
  const std::size_t bytes = std::min(what.text.size(), sizeof fault->text - 1);
  std::memcpy(fault->text, what.text.data(), bytes);
  fault->text[bytes] = '\0';
}

}  // namespace

char* sft_layout_text(const char* text, sft_rule_fault* fault) {
  const auto rule = read_rule(text);
  if (rule) return strdup(rule->text().c_str());
  say(rule.error(), 0, fault);
  return nullptr;
}

bool sft_check_layouts(sft_see see, const void* type, const sft_rule* rules, std::size_t count,
                       sft_rule_fault* fault) {
  std::deque<Rule> read;
  std::vector<RuleOfMember> all;
  for (std::size_t i = 0; i < count; ++i) {
    auto rule = read_rule(rules[i].text);
    if (!rule) return say(rule.error(), i, fault), false;
    all.push_back({rules[i].member, &read.emplace_back(*std::move(rule))});
  }
  const std::optional<Fault> wrong = check_rules(SeenByC(see), type, all);
  if (!wrong) return true;
  const auto number = std::ranges::find(all, wrong->member, &RuleOfMember::member) - all.begin();
  say(*wrong, static_cast<std::size_t>(number), fault);
  return false;
}
