// The errors that a program gets if it must not use the memory of the daemon.
#include "shm_transport/host/membership.h"

#include <gmock/gmock.h>
#include <grp.h>
#include <unistd.h>

namespace sft::shm {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Membership, AUserWhoIsNoMemberIsToldTheGroupAndTheCommand) {
  const std::string text = how_to_join({.group = "sft", .group_id = 990, .user = "ann"});
  EXPECT_THAT(text, HasSubstr("user ann is no member of group sft, which sftd serves"));
  EXPECT_THAT(text, HasSubstr("run: sudo adduser ann sft, log out and in again"));
}

TEST(Membership, AMemberWhoseSessionIsOlderIsToldToLogInAgain) {
  const std::string text = how_to_join({.group = "sft", .group_id = 990, .user = "ann", .is_listed = true});
  EXPECT_THAT(text, AllOf(HasSubstr("not yet in this session"), HasSubstr("log out and in again"),
                          Not(HasSubstr("adduser"))));
}

TEST(Membership, AUserOrAGroupWithoutANameIsToldTheNumberForAContainer) {
  EXPECT_THAT(how_to_join({.group_id = 990, .user = "ann"}),
              AllOf(HasSubstr("group 990;"), HasSubstr("--group-add 990"), Not(HasSubstr("adduser"))));
  EXPECT_THAT(how_to_join({.group = "sft", .group_id = 990}),
              AllOf(HasSubstr("group sft;"), HasSubstr("--group-add 990"), Not(HasSubstr("adduser"))));
}

TEST(Membership, NobodyIsToldToJoinTheGroupOfRoot) {
  EXPECT_THAT(how_to_join({.group = "root", .group_id = 0, .user = "ann"}),
              AllOf(HasSubstr("sudo systemctl start sftd"), Not(HasSubstr("adduser"))));
}

TEST(Membership, OfThisProcessKnowsThePrimaryGroupOfItsUserAndNoGroupThatIsNowhere) {
  const Membership own = Membership::of_this_process(getegid());
  EXPECT_EQ(own.group_id, getegid());
  const Membership unknown = Membership::of_this_process(3'999'999'999);
  EXPECT_EQ(unknown.group, "");
  EXPECT_FALSE(unknown.is_listed);
  if (own.user.empty()) GTEST_SKIP() << "this user has no name here";
  EXPECT_TRUE(own.is_listed);
  EXPECT_FALSE(own.group.empty());
}

}  // namespace
}  // namespace sft::shm
