// What is printed as JSON or YAML and read again is the same message, of every type that there is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "sft/typesupport/dynamic_type.h"
#include "sft/typesupport/dynamic_view.h"
#include "sft/typesupport/json.h"
#include "sft/typesupport/sample_format.h"
#include "sft/typesupport/yaml.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"
#include "tests/support/tame_value.h"

namespace sft {
namespace {

using test::Encoded;
using test::OwnedValue;

using JsonLaw = test::RandomTest;

TEST_F(JsonLaw, AMessageOfEveryTypeComesBackByteByByte) {
  constexpr int rounds = 20;
  test::RandomValues values{random};
  for (const test::MessageType& each : test::every_type()) {
    SCOPED_TRACE(each.support->name());
    const DynamicType type = DynamicType::parse(describe(each.type())).value();
    for (int round = 0; round < rounds; ++round) {
      OwnedValue value = each.make();
      values.fill(value.type(), value.get());
      test::tame(value.type(), value.get());
      const Encoded sample(value.type(), value.get(), each.support->full());
      const auto json =
          to_json(DynamicView(sample.state(), type.type()), {.bytes_as_base64 = random() % 2 == 0});
      ASSERT_TRUE(json) << json.error().message;
      const auto payload = cdr_from_json(type.type(), *json);
      ASSERT_TRUE(payload) << payload.error().message << "\n" << *json;
      const std::vector<std::byte> expected = sample.bytes();
      ASSERT_TRUE(std::equal(payload->begin() + encapsulation_bytes, payload->end(), expected.begin(),
                             expected.end()))
          << *json;
    }
  }
}

TEST_F(JsonLaw, AMessageOfEveryTypeComesBackByteByByteFromYamlToo) {
  constexpr int rounds = 5;
  test::RandomValues values{random};
  for (const test::MessageType& each : test::every_type()) {
    SCOPED_TRACE(each.support->name());
    const DynamicType type = DynamicType::parse(describe(each.type())).value();
    for (int round = 0; round < rounds; ++round) {
      OwnedValue value = each.make();
      values.fill(value.type(), value.get());
      test::tame(value.type(), value.get());
      const Encoded sample(value.type(), value.get(), each.support->full());
      const auto yaml = to_yaml(DynamicView(sample.state(), type.type()),
                                {.elements_max = SIZE_MAX, .text_bytes_max = SIZE_MAX});
      ASSERT_TRUE(yaml) << yaml.error().message;
      const auto payload = json_from_yaml(type.type(), *yaml).and_then([&](const std::string& json) {
        return cdr_from_json(type.type(), json);
      });
      ASSERT_TRUE(payload) << payload.error().message << "\n" << *yaml;
      const std::vector<std::byte> expected = sample.bytes();
      ASSERT_TRUE(std::equal(payload->begin() + encapsulation_bytes, payload->end(), expected.begin(),
                             expected.end()))
          << *yaml;
    }
  }
}

TEST_F(JsonLaw, AnEmptyObjectIsAMessageOfZeros) {
  for (const test::MessageType& each : test::every_type()) {
    const auto payload = cdr_from_json(each.type(), "{}");
    ASSERT_TRUE(payload) << payload.error().message;
    std::vector<std::uint64_t> memory(payload->size() / 8 + 1);
    std::memcpy(memory.data(), payload->data() + encapsulation_bytes, payload->size() - encapsulation_bytes);
    const FieldMask full = each.support->full();
    const SampleState state{.body = reinterpret_cast<const std::byte*>(memory.data()),
                            .body_bytes = static_cast<std::uint32_t>(payload->size() - encapsulation_bytes),
                            .mask = &full};
    std::vector<std::uint32_t> index(each.support->slots());
    EXPECT_EQ(build_index(state, each.type(), index), WalkStatus::ok) << each.support->name();
  }
}

}  // namespace
}  // namespace sft
