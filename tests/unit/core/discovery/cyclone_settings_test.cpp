// SFT reads a user's configuration as Cyclone DDS does, including the deviations in XML and names that
// Cyclone tolerates.
#include "core/discovery/cyclone_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/support/temporary_directory.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Optional;

constexpr std::uint32_t our_domain = 5;

CycloneSettings read(const std::string& config) { return CycloneSettings::read(config, our_domain).value(); }

/// A file with a configuration, deleted with this object.
class ConfigFile {
 public:
  explicit ConfigFile(const std::string& text) : name_(directory_.write("config_of_a_test.xml", text)) {}
  const std::string& name() const { return name_; }

 private:
  const test::TemporaryDirectory directory_;
  const std::string name_;
};

TEST(CycloneSettings, AreFoundByTheirPathBelowTheDomain) {
  const auto settings = read(
      "<CycloneDDS><Domain Id='any'><General><FragmentSize> 9 kB "
      "</FragmentSize></General></Domain></CycloneDDS>");
  EXPECT_THAT(settings.value("General/FragmentSize"), Optional(std::string("9 kB")));
  EXPECT_EQ(settings.value("General"), std::nullopt);
  EXPECT_EQ(settings.value("Discovery/FragmentSize"), std::nullopt);
  EXPECT_TRUE(settings.sets("General"));
  EXPECT_FALSE(settings.sets("Discovery"));
}

TEST(CycloneSettings, InTextMayLackOuterElementsAndEnds) {
  for (const char* text :
       {"<Domain><General><FragmentSize>9 B</></></>", "<General><FragmentSize>9 B</></>",
        "<general><fragmentsize>9 B", "<CycloneDDS><Domain><General><FragmentSize>9 B",
        "<CycloneDDS><General><FragmentSize>9 B", "<DDSI2E><General><FragmentSize>9 B</></></>"}) {
    EXPECT_THAT(read(text).value("General/FragmentSize"), Optional(std::string("9 B"))) << text;
  }
}

TEST(CycloneSettings, OfTheLastOneHold) {
  const auto settings = read("<General><FragmentSize>1 B</></>,<General><FragmentSize>2 B</></>");
  EXPECT_THAT(settings.value("General/FragmentSize"), Optional(std::string("2 B")));
}

TEST(CycloneSettings, ThatAreListsHaveAllTheirValues) {
  const auto settings = read("<Discovery><Peers><Peer Address='a'/><Peer Address='b'/></Peers></Discovery>");
  EXPECT_THAT(settings.values("Discovery/Peers/Peer/@Address"), ElementsAre("a", "b"));
}

TEST(CycloneSettings, OfOtherDomainsAreSkipped) {
  const auto settings = read(
      "<CycloneDDS><Domain Id='6'><General><FragmentSize>6 B</FragmentSize></General></Domain>"
      "<Domain Id='5'><Internal><MaxSampleSize>5 B</MaxSampleSize></Internal></Domain></CycloneDDS>");
  EXPECT_EQ(settings.value("General/FragmentSize"), std::nullopt);
  EXPECT_TRUE(settings.value("Internal/MaxSampleSize"));
  EXPECT_FALSE(settings.only_for_others());
  EXPECT_TRUE(read("<Domain id='6'><General><FragmentSize>6 B</></></>").only_for_others());
  EXPECT_TRUE(read("<Domain><Id>6</Id><General><FragmentSize>6 B</></></>").only_for_others());
  EXPECT_FALSE(read("").only_for_others());
}

TEST(CycloneSettings, BeforeTheNumberOfAnotherDomainHold) {
  const auto settings =
      read("<Domain><General><FragmentSize>5 B</></><Id>6</><Internal><NackDelay>6 ms</></></>");
  EXPECT_THAT(settings.value("General/FragmentSize"), Optional(std::string("5 B")));
  EXPECT_EQ(settings.value("Internal/NackDelay"), std::nullopt);
}

TEST(CycloneSettings, ThatAreEmptySetNothing) {
  EXPECT_FALSE(read("<General/>").sets("General"));
  EXPECT_TRUE(read("<Domain Id='6'><General/></>").only_for_others());
}

TEST(CycloneSettings, OfFilesAndTextsAreReadInOrder) {
  const ConfigFile file(
      "<CycloneDDS><Domain><General><FragmentSize>3 B</FragmentSize></General></Domain></CycloneDDS>");
  const std::string text = "<General><FragmentSize>4 B</></>";
  for (const std::string& name : {file.name(), "file://" + file.name()}) {
    EXPECT_THAT(read(name + "," + text).value("General/FragmentSize"), Optional(std::string("4 B")));
    EXPECT_THAT(read(" " + text + ", " + name).value("General/FragmentSize"), Optional(std::string("3 B")));
  }
}

TEST(CycloneSettings, OfAFileThatCannotBeReadAreAnErrorThatNamesIt) {
  const auto settings = CycloneSettings::read("<General/>,file:///nowhere/cyclone.xml", our_domain);
  ASSERT_FALSE(settings);
  EXPECT_THAT(settings.error().message, HasSubstr("CYCLONEDDS_URI"));
  EXPECT_THAT(settings.error().message,
              HasSubstr("'file:///nowhere/cyclone.xml': /nowhere/cyclone.xml: No such file"));
  const auto directory = CycloneSettings::read("file:///tmp", our_domain);
  ASSERT_FALSE(directory);
  EXPECT_THAT(directory.error().message, HasSubstr("/tmp: this is a directory"));
}

TEST(CycloneSettings, ThatAreNestedTooDeeplyAreAnError) {
  std::string text;
  for (int i = 0; i < 100'000; ++i) text += "<a>";
  const auto settings = CycloneSettings::read(text, our_domain);
  ASSERT_FALSE(settings);
  EXPECT_THAT(settings.error().message, HasSubstr("elements are nested too deeply"));
}

TEST(CycloneSettings, ThatAreMalformedAreAnErrorThatSaysWhere) {
  const auto text = CycloneSettings::read("<General>\n<FragmentSize", our_domain);
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().message, HasSubstr("CYCLONEDDS_URI"));
  EXPECT_THAT(text.error().message, HasSubstr("line 2"));
  const auto file = CycloneSettings::read(ConfigFile("<CycloneDDS><Domain></CycloneDDS>").name(), our_domain);
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().message, HasSubstr("config_of_a_test.xml"));
}

TEST(CycloneSettings, HoldTheValuesOfVariables) {
  setenv("SFT_TEST_FRAGMENT", "7 B", 1);
  EXPECT_THAT(read("<General><FragmentSize>${SFT_TEST_FRAGMENT}</></>").value("General/FragmentSize"),
              Optional(std::string("7 B")));
}

TEST(CycloneSettings, CanBeWrittenOnceMoreForAnyDomainWithoutSomeOfThem) {
  setenv("SFT_TEST_FRAGMENT", "7 B", 1);
  const auto once = read(
      "<General><FragmentSize>${SFT_TEST_FRAGMENT}</><Interfaces><NetworkInterface name='a&amp;\"b'/></></>"
      "<Discovery><Peers><Peer Address='p'/><Peer Address='q'/></></>,<Domain Id='5'><Internal><NackDelay>5 "
      "ms</>"
      "</></>,<Domain Id='6'><Internal><NackDelay>6 ms</></></>");
  const auto all = CycloneSettings::read(once.for_any_domain({}), 1000).value();
  EXPECT_THAT(all.value("General/FragmentSize"), Optional(std::string("7 B")));
  EXPECT_THAT(all.value("Internal/NackDelay"), Optional(std::string("5 ms")));
  EXPECT_THAT(all.values("Discovery/Peers/Peer/@Address"), testing::ElementsAre("p", "q"));
  EXPECT_THAT(all.values("General/Interfaces/NetworkInterface/@name"), testing::ElementsAre("a&\"b"));
  const auto less = CycloneSettings::read(once.for_any_domain({"General/Interfaces"}), 1000).value();
  EXPECT_FALSE(less.sets("General/Interfaces"));
  EXPECT_TRUE(less.sets("General/FragmentSize"));
  const std::string suffices = "<General>\n<FragmentSize>4 B</></>";
  EXPECT_EQ(read(suffices).for_any_domain({"General/Interfaces"}), suffices);
}

}  // namespace
}  // namespace sft::core
