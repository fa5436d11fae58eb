// Stored inputs of fuzz_decoder, and randomly damaged bodies. fuzz_decoder.cpp has the checks.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/fuzz/decoder_input.h"
#include "tests/support/encoded.h"
#include "tests/support/random_value.h"
#include "tests/support/recorded_data.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 40
#endif

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace sft::test {
namespace {

void decode_any(const std::vector<std::byte>& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

TEST(DecoderInputsTest, OfTheKeptCorpusHoldWhatTheFuzzerRequires) {
  int inputs = 0;
  for (const auto& file : std::filesystem::directory_iterator(SFT_DECODER_CORPUS)) {
    EXPECT_NO_THROW(decode_any(read_recording(file.path()).value())) << file.path();
    ++inputs;
  }
  EXPECT_GT(inputs, 0);
}

TEST(DecoderInputsTest, AreParsedAsTheyWereMade) {
  const MessageType& type = every_type()[1];
  const std::vector<std::byte> body(5, std::byte{7});
  const auto input =
      make_decoder_input(1, *type.support->find("header"), *type.support->find("header.stamp"), body);
  const auto parsed = parse_decoder_input(input);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->type->support, type.support);
  EXPECT_EQ(parsed->mask, *type.support->find("header"));
  EXPECT_EQ(parsed->narrower, *type.support->find("header.stamp"));
  EXPECT_EQ(std::vector<std::byte>(parsed->body.begin(), parsed->body.end()), body);
}

TEST(DecoderInputsTest, CanNameEveryType) { EXPECT_LE(every_type().size(), 65536U); }

class DamagedBodies : public RandomTest, public ::testing::WithParamInterface<std::size_t> {
 protected:
  std::vector<std::byte> valid_input() {
    const MessageType& type = every_type()[GetParam()];
    OwnedValue value = type.make();
    values.fill(type.type(), value.get());
    const FieldMask mask = type.support->closed(values.mask(type.support->leaves()));
    const Encoded encoded(type.type(), value.get(), mask);
    return make_decoder_input(GetParam(), mask, values.mask(mask.leaves()), encoded.bytes());
  }

  void damage(std::vector<std::byte>& input) {
    for (std::size_t i = values.up_to(3); i > 0; --i) {
      input[1 + values.up_to(input.size() - 2)] = static_cast<std::byte>(random() >> values.up_to(8));
    }
    input.resize(input.size() - std::min(input.size() - 1, values.up_to(4)));
  }

  RandomValues values{random};
};

TEST_P(DamagedBodies, AreRefusedOrDecodedAndNeverReadOutside) {
  for (int round = 0; round < SFT_TEST_ROUNDS; ++round) {
    std::vector<std::byte> input = valid_input();
    ASSERT_NO_THROW(decode_any(input)) << "undamaged, in round " << round;
    damage(input);
    ASSERT_NO_THROW(decode_any(input)) << "in round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, DamagedBodies, ::testing::Range(std::size_t{0}, every_type().size()),
                         [](const auto& number) { return every_type()[number.param].test_name(); });

}  // namespace
}  // namespace sft::test
