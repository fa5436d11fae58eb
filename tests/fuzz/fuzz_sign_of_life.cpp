// Signs of life as they come from the control topics, with whatever in them: nothing is read behind a
// sequence, what is taken is within the bounds, and is written again as it was.
#include <fuzzer/FuzzedDataProvider.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "core/control/control_codec.h"

namespace sft::core {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports it as a crash
}

/// Returns at most so many elements, in memory that ends where they end.
template <class Element>
std::vector<Element> elements(FuzzedDataProvider& data, std::size_t most) {
  std::vector<Element> all(data.ConsumeIntegralInRange<std::size_t>(0, most));
  for (Element& element : all) data.ConsumeData(&element, sizeof element);
  all.shrink_to_fit();
  return all;
}

template <class Sequence, class Element>
void put(Sequence& sequence, std::vector<Element>& elements) {
  const auto count = static_cast<std::uint32_t>(elements.size());
  sequence = {count, count, elements.data(), false};
}

void check(FuzzedDataProvider data) {
  sft_control_Assertion sample{};
  sample.version = data.ConsumeBool() ? sft_control_protocol_version : data.ConsumeIntegral<std::uint8_t>();
  sample.node = data.ConsumeIntegral<std::uint64_t>();
  auto accounts = elements<sft_control_Account>(data, accounts_max + 2);
  auto asked_about = elements<std::uint64_t>(data, asked_about_max + 2);
  auto progress = elements<sft_control_Progress>(data, progress_max + 2);
  auto writers = elements<std::uint64_t>(data, assertions_max + 2);
  sft_control_SignNews news{};
  put(news.accounts, accounts);
  put(news.asked_about, asked_about);
  put(news.progress, progress);
  put(news.writers, writers);
  sample.news._d = data.ConsumeBool();
  if (sample.news._d) sample.news._u.news = news;
  const Result<Assertion> taken = from_dds(sample);
  if (!taken) return require(!taken.error().message.empty(), "an error says what is wrong");
  require(taken->accounts.size() <= accounts_max && taken->asked_about.size() <= asked_about_max &&
              taken->progress.size() <= progress_max && taken->writers.size() <= assertions_max,
          "there is room for no more");
  ControlStorage storage;
  require(from_dds(to_dds(*taken, storage)) == *taken, "what is written again is the same");
}

}  // namespace
}  // namespace sft::core

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sft::core::check(FuzzedDataProvider(data, size));
  return 0;
}
