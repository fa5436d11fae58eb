// Takes what a reader of Cyclone's has.
#pragma once

#include <dds/dds.h>

#include <array>
#include <cstddef>

namespace sft::core {

/// Takes all that a reader has, in batches, and calls `use(sample, info)`. Cyclone reports once more what
/// comes after the last batch.
template <class Sample, class Use>
void take_all(dds_entity_t reader, Use use) {
  constexpr std::size_t batch = 16;
  std::array<void*, batch> samples{};
  std::array<dds_sample_info_t, batch> infos{};
  for (;;) {
    const dds_return_t n = dds_take(reader, samples.data(), infos.data(), batch, batch);
    if (n <= 0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      use(*static_cast<const Sample*>(samples[i]), infos[i]);
    }
    dds_return_loan(reader, samples.data(), n);
    if (static_cast<std::size_t>(n) < batch) return;
    samples[0] = nullptr;
  }
}

}  // namespace sft::core
