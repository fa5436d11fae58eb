#include "bench/common/message_set.h"

namespace sft::bench {

std::size_t Messages::largest() const {
  return std::ranges::max(bodies_, {}, &std::vector<std::byte>::size).size();
}

FieldMask Messages::mask_of(FieldSet fields) const {
  FieldMask mask = type().none();
  const auto& members = type().type().members;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if ((fields >> i & 1) != 0) mask = mask | type().find(members[i].name).value();
  }
  return mask;
}

FieldSet Messages::named(const std::vector<std::string>& names) const {
  FieldSet fields = 0;
  const auto& members = type().type().members;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (std::ranges::find(names, members[i].name) != names.end()) fields |= FieldSet{1} << i;
  }
  return fields;
}

}  // namespace sft::bench
