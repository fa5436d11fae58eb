// After an act all honest programs work as before. The test tries each act of the table; the act begins
// before, while or after the programs start. `./run bench recovery` measures how soon all programs work
// again, and checks this time against a limit.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <vector>

#include "tests/hostile/stage.h"
#include "tests/support/test_seed.h"

namespace sft::hostile {

/// Declared in this namespace, where GoogleTest looks for it.
void PrintTo(const Entry& entry, std::ostream* out) { *out << entry.name; }

namespace {

using namespace std::chrono_literals;

constexpr Ms length_of_an_act = 800ms;

class Hostile : public test::RandomTest, public ::testing::WithParamInterface<Entry> {
 protected:
  void SetUp() override {
    if (const std::string refusal = Stage::refusal(); !refusal.empty()) GTEST_SKIP() << refusal;
  }

  void expect_that_all_works_again(Moment moment, Certificates certificates) {
    SCOPED_TRACE(std::string(GetParam().sentence) + " It begins " + std::string(to_string(moment)) + ".");
    Stage stage(random(), certificates);
    const Outcome outcome = stage.perform(GetParam(), moment, length_of_an_act);
    for (const std::string& complaint : outcome.complaints) ADD_FAILURE() << complaint;
    for (const std::string& complaint : stage.end()) ADD_FAILURE() << complaint;
  }

  /// Tries the act at one of the three moments or, with SFT_TEST_TIMES=3 or more, at all of them in turn.
  void expect_that_all_works_again(Certificates certificates) {
    const std::uint64_t first = random();
    for (std::uint64_t i = 0; i < test::test_rounds(1); ++i)
      expect_that_all_works_again(moments[(first + i) % moments.size()], certificates);
  }
};

TEST_P(Hostile, ActsCostNoMoreThanTheirTime) { expect_that_all_works_again(Certificates::none); }

/// Acts in the names of other participants, against programs with certificates.
class HostileToCertified : public Hostile {};

TEST_P(HostileToCertified, ActsCostNothing) { expect_that_all_works_again(Certificates::all); }

/// Returns the acts in the names of other participants. Leaves out forged_deaths, because DDS Security does
/// not protect the end of a participant (SECURITY.md).
std::vector<Entry> forging_acts() {
  std::vector<Entry> forging;
  std::ranges::copy_if(acts(), std::back_inserter(forging), [](const Entry& entry) {
    return entry.harm == Harm::forges && entry.name != std::string_view("forged_deaths");
  });
  return forging;
}

std::string name_of(const ::testing::TestParamInfo<Entry>& info) { return std::string(info.param.name); }

INSTANTIATE_TEST_SUITE_P(Acts, Hostile, ::testing::ValuesIn(acts().begin(), acts().end()), name_of);
INSTANTIATE_TEST_SUITE_P(Acts, HostileToCertified, ::testing::ValuesIn(forging_acts()), name_of);

}  // namespace
}  // namespace sft::hostile
