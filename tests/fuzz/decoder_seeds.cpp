// decoder_seeds DIRECTORY: writes seed inputs of fuzz_decoder: small messages of all types.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/fuzz/decoder_input.h"
#include "tests/support/encoded.h"
#include "tests/support/foreign_cdr.h"
#include "tests/support/random_value.h"

namespace sft::test {
namespace {

constexpr std::size_t body_bytes_wanted = 160;
constexpr std::size_t input_bytes_max = 400;

std::size_t distance(std::size_t a, std::size_t b) { return a > b ? a - b : b - a; }

/// Makes many random inputs. Returns the one whose size is closest to the wanted size, which is small but not
/// 0.
template <class RandomInput>
std::vector<std::byte> small_input(RandomInput random_input) {
  std::vector<std::byte> best;
  std::size_t best_distance = SIZE_MAX;
  for (int i = 0; i < 1000; ++i) {
    const std::vector<std::byte> input = random_input();
    if (distance(input.size(), body_bytes_wanted) >= best_distance) continue;
    best_distance = distance(input.size(), body_bytes_wanted);
    best = input;
  }
  return best;
}

class Seeds {
 public:
  explicit Seeds(std::size_t number) : number_(number) {}

  std::vector<std::byte> masked(bool full) {
    return small_input([&] {
      const OwnedValue value = random_value();
      const FieldMask mask =
          full ? type_.support->full() : type_.support->closed(values_.mask(type_.support->leaves()));
      return input(mask, Encoded(type_.type(), value.get(), mask).bytes());
    });
  }
  std::vector<std::byte> foreign(const ForeignEncoding& encoding) {
    return small_input([&] { return input(type_.support->full(), foreign_cdr(random_value(), encoding)); });
  }

 private:
  OwnedValue random_value() {
    OwnedValue value = type_.make();
    values_.fill(type_.type(), value.get());
    return value;
  }
  std::vector<std::byte> input(const FieldMask& mask, const std::vector<std::byte>& body) {
    return make_decoder_input(number_, mask, values_.mask(type_.support->leaves()), body);
  }

  std::size_t number_;
  const MessageType& type_ = every_type()[number_];
  Random random_{number_ + 1};
  RandomValues values_{random_};
};

void save(const std::filesystem::path& file, const std::vector<std::byte>& bytes) {
  if (bytes.size() > input_bytes_max) return;
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
  for (std::size_t i = 0; i < sft::test::every_type().size(); ++i) {
    const std::string name = directory / sft::test::every_type()[i].test_name();
    sft::test::Seeds seeds(i);
    sft::test::save(name + "_full", seeds.masked(true));
    sft::test::save(name + "_masked", seeds.masked(false));
    for (const auto& encoding : sft::test::foreign_encodings().subspan(1, 3))
      sft::test::save(name + "_" + encoding.name, seeds.foreign(encoding));
  }
}
