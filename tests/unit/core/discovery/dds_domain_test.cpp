// Links of a process share a domain of Cyclone only if sharing is allowed.
#include "core/discovery/dds_domain.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

bool are_shared(const DomainPlan& a, const DomainPlan& b) { return !(a < b) && !(b < a); }

TEST(DomainPlanTest, IsNotThatOfACardWhichCameBackWithItsNameAndAddress) {
  const DomainPlan plan{.config = "<CycloneDDS/>", .index = 2};
  DomainPlan of_new_card = plan;
  EXPECT_TRUE(are_shared(plan, of_new_card));
  of_new_card.index = 3;
  EXPECT_FALSE(are_shared(plan, of_new_card));
}

}  // namespace
}  // namespace sft::core
