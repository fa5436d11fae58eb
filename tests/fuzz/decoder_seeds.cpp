// decoder_seeds DIRECTORY: writes first inputs of fuzz_decoder, small messages of all types.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/fuzz/decoder_input.h"
#include "tests/support/encoded.h"
#include "tests/support/random_value.h"

namespace sft::test {
namespace {

constexpr std::size_t body_bytes_wanted = 160;
constexpr std::size_t input_bytes_max = 400;

std::size_t distance(std::size_t a, std::size_t b) { return a > b ? a - b : b - a; }

/// Of some random messages the one of which the size is best: small, but not empty all through.
std::vector<std::byte> small_input(std::size_t number, Random& random, bool full) {
  RandomValues values(random);
  const MessageType& type = all_types()[number];
  std::vector<std::byte> best;
  std::size_t best_distance = SIZE_MAX;
  for (int i = 0; i < 1000; ++i) {
    OwnedValue value = type.make();
    values.fill(type.type(), value.get());
    const FieldMask mask =
        full ? type.support->full() : type.support->closed(values.mask(type.support->leaves()));
    const FieldMask narrower = values.mask(type.support->leaves());
    const std::vector<std::byte> body = Encoded(type.type(), value.get(), mask).bytes();
    if (distance(body.size(), body_bytes_wanted) >= best_distance) continue;
    best_distance = distance(body.size(), body_bytes_wanted);
    best = make_decoder_input(number, mask, narrower, body);
  }
  return best;
}

void save(const std::filesystem::path& file, const std::vector<std::byte>& bytes) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace
}  // namespace sft::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: decoder_seeds DIRECTORY\n", stderr);
    return 1;
  }
  const std::filesystem::path directory = argv[1];
  std::filesystem::create_directories(directory);
  sft::test::Random random(1);
  for (std::size_t i = 0; i < sft::test::all_types().size(); ++i) {
    for (const bool full : {true, false}) {
      const auto input = sft::test::small_input(i, random, full);
      if (input.size() > sft::test::input_bytes_max) continue;
      sft::test::save(directory / (sft::test::all_types()[i].short_name() + (full ? "_full" : "_masked")),
                      input);
    }
  }
}
