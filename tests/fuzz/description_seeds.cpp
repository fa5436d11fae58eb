// description_seeds DIRECTORY: writes seed inputs of fuzz_type_description: small messages of all types.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "sft/detail/type_description.h"
#include "tests/fuzz/description_input.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"

namespace sft::test {
namespace {

using namespace detail;

constexpr std::size_t input_bytes_max = 1000;

/// Returns the smallest of many random inputs. Each has a message of at least 100 bytes, so that few fields
/// are empty.
std::vector<std::byte> small_input(const MessageType& type, Random& random) {
  RandomValues values(random);
  const std::vector<std::byte> description = describe(type.type());
  std::vector<std::byte> best;
  for (int i = 0; i < 1000; ++i) {
    OwnedValue value = type.make();
    values.fill(value.type(), value.get());
    const FieldMask mask = type.support->closed(values.mask(type.support->leaves()));
    const std::vector<std::byte> body = Encoded(type.type(), value.get(), mask).bytes();
    if (body.size() < 100 || (!best.empty() && best.size() < body.size() + description.size())) continue;
    best = make_description_input(description, mask, body);
  }
  return best;
}

}  // namespace
}  // namespace sft::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: description_seeds DIRECTORY\n", stderr);
    return 1;
  }
  const std::filesystem::path directory = argv[1];
  std::filesystem::create_directories(directory);
  sft::test::Random random(1);
  for (const sft::test::MessageType& type : sft::test::all_types()) {
    const std::vector<std::byte> input = sft::test::small_input(type, random);
    if (input.empty() || input.size() > sft::test::input_bytes_max) continue;
    std::ofstream stream(directory / type.short_name(), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
  }
}
