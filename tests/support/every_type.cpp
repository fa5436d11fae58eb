#include <algorithm>

#include "tests/support/message_types.h"

namespace sft::test {

namespace {

std::vector<MessageType> make_every_type() {
  std::vector<MessageType> others = generated_types();
  std::erase_if(others, [](const MessageType& type) {
    return std::ranges::find(all_types(), type.support, &MessageType::support) != all_types().end();
  });
  std::ranges::sort(others, {}, [](const MessageType& type) { return type.support->name(); });
  std::vector<MessageType> types(all_types().begin(), all_types().end());
  types.insert(types.end(), others.begin(), others.end());
  return types;
}

}  // namespace

std::span<const MessageType> every_type() {
  static const std::vector<MessageType> types = make_every_type();
  return types;
}

}  // namespace sft::test
