#include "bench/paper/configuration.h"

#include <random>

namespace sft::bench::paper {

// The standard defines the numbers of these two, but not those of its distributions.
FieldSet draw_fields(std::uint64_t seed, const Configuration& of, std::size_t repeat, std::size_t receiver) {
  std::seed_seq all{seed,
                    seed >> 32,
                    std::uint64_t{of.fields},
                    std::uint64_t{of.field_bytes},
                    std::uint64_t{of.receivers},
                    static_cast<std::uint64_t>(of.percent),
                    std::uint64_t{repeat},
                    std::uint64_t{receiver}};
  std::mt19937_64 numbers(all);
  FieldSet fields = 0;
  for (std::size_t i = 0; i < of.fields; ++i) {
    const auto percentile = static_cast<int>(numbers() % 100);
    if (percentile < of.percent) fields |= FieldSet{1} << i;
  }
  return fields;
}

}  // namespace sft::bench::paper
