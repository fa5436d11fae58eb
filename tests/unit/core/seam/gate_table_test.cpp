// The table after a sample in shared memory, which lists the gates that the sample has passed.
#include "core/seam/gate_table.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>

#include "core/seam/buffer_pool.h"

namespace sft::core {
namespace {

constexpr std::size_t slots = 3;
constexpr std::uint32_t body_bytes = 13;

std::shared_ptr<Gate> gate_with(std::uint64_t hash, bool passes) {
  const std::vector<Selection::Condition> conditions{
      {.kind = Selection::Condition::Kind::nth, .number = std::uint64_t{1}}};
  auto gate = std::make_shared<Gate>(
      0, detail::Conditions(detail::TypeTable<sensor_msgs::msg::PointCloud2>::type, conditions), hash);
  if (passes) gate->reader_begins();
  gate->consider(detail::FieldSource::of_nothing(), 1);
  return gate;
}

class GateTableTest : public ::testing::Test {
 protected:
  /// Returns a sample with memory for a table of `gates` gates.
  SampleHandle sample(std::size_t gates) {
    SampleHandle made = pool->take(detail::SampleLayout(slots).bytes(body_bytes) + gate_table_bytes(gates));
    made->header() = {};
    made->header().body_bytes = body_bytes;
    return made;
  }
  static std::optional<std::uint32_t> ordinal(const SampleHandle& sample, const Gate& gate) {
    return ordinal_in_gate(*sample, slots, gate.id());
  }

  const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 20);
};

TEST_F(GateTableTest, NamesTheGatesThatTheSampleHasPassedWithItsNumber) {
  const std::vector gates{gate_with(1, true), gate_with(2, false), gate_with(3, true)};
  gates[2]->consider(detail::FieldSource::of_nothing(), 2);
  const SampleHandle made = sample(gates.size());
  write_gate_table(*made, slots, gates);
  EXPECT_EQ(ordinal(made, *gates[0]), 1U);
  EXPECT_EQ(ordinal(made, *gates[1]), std::nullopt);
  EXPECT_EQ(ordinal(made, *gates[2]), 2U);
  EXPECT_EQ(ordinal_in_gate(*made, slots, 77), std::nullopt);
}

TEST_F(GateTableTest, ASampleWithoutRoomHasNoTable) {
  const std::vector gates{gate_with(1, true)};
  const SampleHandle made = sample(0);
  made->capacity = detail::SampleLayout(slots).bytes(body_bytes);
  write_gate_table(*made, slots, gates);
  EXPECT_EQ(made->header().gates, 0U);
  EXPECT_EQ(ordinal(made, *gates[0]), std::nullopt);
}

TEST_F(GateTableTest, HasNoMoreEntriesThanItMayHave) {
  std::vector<std::shared_ptr<Gate>> gates;
  for (std::uint64_t hash = 1; hash <= gates_in_table_max + 5; ++hash) gates.push_back(gate_with(hash, true));
  const SampleHandle made = sample(gates.size());
  write_gate_table(*made, slots, gates);
  EXPECT_EQ(ordinal(made, *gates[gates_in_table_max - 1]), 1U);
  EXPECT_EQ(ordinal(made, *gates[gates_in_table_max]), std::nullopt);
}

TEST_F(GateTableTest, ATableThatEndsBehindTheMemoryIsNoTable) {
  const std::vector gates{gate_with(1, true)};
  const SampleHandle made = sample(gates.size());
  write_gate_table(*made, slots, gates);
  const std::size_t end = bytes_with_gate_table(detail::SampleLayout(slots).bytes(body_bytes), 1);
  made->capacity = end;
  EXPECT_EQ(ordinal(made, *gates[0]), 1U);
  made->capacity = end - 1;
  EXPECT_EQ(ordinal(made, *gates[0]), std::nullopt);
  made->capacity = end;
  for (const std::uint16_t written : {2, 64, 65, 65535}) {
    made->header().gates = written;
    EXPECT_EQ(ordinal(made, *gates[0]), std::nullopt) << written;
  }
  made->header().gates = 1;
  made->header().body_bytes = 0xFFFF'FFFF;
  EXPECT_EQ(ordinal(made, *gates[0]), std::nullopt);
}

}  // namespace
}  // namespace sft::core
