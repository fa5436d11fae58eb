// A program has set the locale of C++ for all of its threads, with which streams write 1000000.5
// as 1.000.000,5. Its nodes find each other, share memory, and understand each other's texts, as those of any
// other program.
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <locale>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

class Punctuation : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

class ForeignLocale {
 public:
  ForeignLocale() : before_(std::locale::global(std::locale(std::locale::classic(), new Punctuation))) {}
  ~ForeignLocale() { std::locale::global(before_); }
  ForeignLocale(const ForeignLocale&) = delete;
  ForeignLocale& operator=(const ForeignLocale&) = delete;

 private:
  const std::locale before_;
};

class LocaleTest : public PubSubTest {
 protected:
  const ForeignLocale locale_;
};

INSTANTIATE_TEST_SUITE_P(Ways, LocaleTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

TEST_P(LocaleTest, SamplesArriveAndTextsHaveTheirNumbers) {
  Node source = open("source"), app = open("app");
  auto pub =
      source.publisher<PointCloud2>("points", {.reliability = reliable, .deadline = hang_timeout}).value();
  const auto type = app.find_type("points", hang_timeout).value();
  const char* const selection = "height @ height > 1234567.5 or every 1000.5 s";
  auto sub = app.subscriber("points", type, selection, {.reliability = reliable}).value();
  expect_served(pub, 1);
  pub.publish(cloud(2'000'000, 5000));
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample.info().transport, in_shared_memory() ? TransportKind::shm : TransportKind::udp);
  const auto json = nlohmann::json::parse(sample.to_json().value());
  EXPECT_EQ(json["height"], 2'000'000);
  EXPECT_EQ(nlohmann::json::parse(to_json(app.snapshot()))["subscribers"][0]["received"], 1);
}

}  // namespace
}  // namespace sft::test
