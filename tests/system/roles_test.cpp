// A node with readers receives the records of writers, and a node with writers the records of readers. A
// node receives all records once it has requested them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/system/control_reader.h"

namespace sft::test {
namespace {

using core::Role;
using ::testing::ElementsAre;

enum class Nodes : std::uint8_t { of_one_process, of_several_processes };

class RolesTest : public ::testing::TestWithParam<Nodes> {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }
  static std::string process(const std::string& name) {
    return GetParam() == Nodes::of_one_process ? "" : name;
  }
};
INSTANTIATE_TEST_SUITE_P(Nodes, RolesTest,
                         ::testing::Values(Nodes::of_one_process, Nodes::of_several_processes),
                         [](const auto& param) {
                           return param.param == Nodes::of_one_process ? "OfOneProcess"
                                                                       : "OfSeveralProcesses";
                         });

TEST_P(RolesTest, ReadersHearOfWritersOnlyAndWritersOfReadersUntilTheyAreToldToHearMore) {
  ControlReader reader(process("a")), other_reader(process("b")), writer(process("c"));
  reader.announce(Role::reader, 1);
  other_reader.announce(Role::reader, 2);
  writer.announce(Role::writer, 3);
  EXPECT_TRUE(writer.hears(1) && writer.hears(2));
  EXPECT_TRUE(reader.hears(3) && other_reader.hears(3));
  other_reader.announce(Role::writer, 4);  // announced after reader 2 of the same node
  EXPECT_TRUE(reader.hears(4));
  EXPECT_THAT(reader.heard(), ElementsAre(3, 4));
  EXPECT_THAT(writer.heard(), ElementsAre(1, 2));
  reader.hear(Role::reader);
  EXPECT_TRUE(reader.hears(2)) << "though it was announced before";
  writer.hear(Role::writer);
  EXPECT_TRUE(writer.hears(4));
}

TEST_P(RolesTest, WhoeverHasNoEndpointHearsWhatItIsToldToHear) {
  ControlReader reader(process("a")), writer(process("b")), observer(process("c"));
  reader.announce(Role::reader, 1);
  writer.announce(Role::writer, 2);
  EXPECT_TRUE(reader.hears(2) && writer.hears(1));
  EXPECT_THAT(observer.heard(), ElementsAre());
  observer.hear(Role::writer);
  EXPECT_TRUE(observer.hears(2));
  EXPECT_THAT(observer.heard(), ElementsAre(2));
  observer.hear(Role::reader);
  EXPECT_TRUE(observer.hears(1));
  reader.withdraw(1);
  EXPECT_TRUE(eventually([&] { return !observer.heard().contains(1) && !writer.heard().contains(1); }));
}

TEST_P(RolesTest, AWriterThatComesLateHearsTheLatestRequestOfEachReader) {
  ControlReader reader(process("a")), writer(process("b"));
  reader.announce(Role::reader, 1);
  for (std::uint64_t sequence = 1; sequence < 10; ++sequence) reader.ask(1, sequence);
  writer.announce(Role::writer, 2);
  EXPECT_TRUE(eventually([&] { return writer.asked() == 9; }));
}

}  // namespace
}  // namespace sft::test
