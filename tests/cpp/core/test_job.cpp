#include "tests.h"

namespace isimp {
namespace {

TEST(Job, StagesMapReportsIntoTheirShareAndNest) {
  Job job;
  {
    Job::Stage outer(job, "outer", 0.5, 1.0);
    EXPECT_STREQ(job.stage(), "outer");
    EXPECT_DOUBLE_EQ(job.progress(), 0.5);
    {
      Job::Stage inner(job, "inner", 0.0, 0.5);  // [0.5, 0.75] of the whole
      job.report(0.5);
      EXPECT_STREQ(job.stage(), "inner");
      EXPECT_DOUBLE_EQ(job.progress(), 0.625);
    }
    EXPECT_STREQ(job.stage(), "outer");
    EXPECT_DOUBLE_EQ(job.progress(), 0.75);
    job.report(0.2);  // 0.6 of the whole: progress never falls
    EXPECT_DOUBLE_EQ(job.progress(), 0.75);
  }
  EXPECT_DOUBLE_EQ(job.progress(), 1.0);
}

TEST(Job, CancelThrowsAtTheNextPollAndKeepsProgress) {
  Job job;
  job.report(0.25);
  job.cancel();
  EXPECT_THROW(job.poll(), Cancelled);
  EXPECT_THROW(job.report(0.5), Cancelled);
  EXPECT_THROW(Job::Stage(job, "late", 0.0, 1.0), Cancelled);
  EXPECT_DOUBLE_EQ(job.progress(), 0.25);
}

}  // namespace
}  // namespace isimp
