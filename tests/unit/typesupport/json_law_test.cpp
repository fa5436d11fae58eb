// Messages of all types are printed as JSON or YAML and read back. The result is the same message.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "sft/detail/sample_format.h"
#include "sft/detail/type_description.h"
#include "sft/dynamic_type.h"
#include "sft/dynamic_view.h"
#include "sft/json.h"
#include "sft/yaml.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"
#include "tests/support/tame_value.h"

namespace sft {
namespace {

using namespace detail;

using test::Encoded;
using test::OwnedValue;

class JsonLaw : public test::RandomTest {
 protected:
  /// Checks random messages of each type. `print` makes text from a view of the message. `read` makes a
  /// payload from that text and the type. Expects the payload to have the bytes of the message.
  template <class Print, class Read>
  void expect_to_come_back(int rounds, Print print, Read read) {
    test::RandomValues values{random};
    for (const test::MessageType& each : test::every_type()) {
      SCOPED_TRACE(each.support->name());
      const DynamicType type = DynamicType::parse(describe(each.type())).value();
      for (int round = 0; round < rounds; ++round) {
        OwnedValue value = each.make();
        values.fill(value.type(), value.get());
        test::tame(value.type(), value.get());
        const Encoded sample(value.type(), value.get(), each.support->full());
        const Result<std::string> text = print(DynamicView(sample.state(), type.type()));
        ASSERT_TRUE(text) << text.error().message;
        const Result<std::vector<std::byte>> payload = read(type.type(), *text);
        ASSERT_TRUE(payload) << payload.error().message << "\n" << *text;
        const std::vector<std::byte> expected = sample.bytes();
        ASSERT_TRUE(std::equal(payload->begin() + encapsulation_bytes, payload->end(), expected.begin(),
                               expected.end()))
            << *text;
      }
    }
  }
};

TEST_F(JsonLaw, AMessageOfEveryTypeComesBackByteByByte) {
  const auto print = [&](const DynamicView& view) {
    return to_json(view, {.bytes_as_base64 = random() % 2 == 0});
  };
  const auto read = [](const StructType& type, const std::string& text) { return cdr_from_json(type, text); };
  expect_to_come_back(20, print, read);
}

TEST_F(JsonLaw, AMessageOfEveryTypeComesBackByteByByteFromYamlToo) {
  const auto print = [](const DynamicView& view) {
    return to_yaml(view, {.elements_max = SIZE_MAX, .text_bytes_max = SIZE_MAX});
  };
  const auto read = [](const StructType& type, const std::string& text) {
    return json_from_yaml(type, text).and_then([&](const std::string& json) {
      return cdr_from_json(type, json);
    });
  };
  expect_to_come_back(5, print, read);
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
    std::vector<std::uint32_t> index(each.support->index_slots());
    EXPECT_EQ(build_index(state, each.type(), index), WalkStatus::ok) << each.support->name();
  }
}

}  // namespace
}  // namespace sft
