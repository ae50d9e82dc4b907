// Distances with answers worked out by hand, and what must not change them.

#include "study/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <fumarole/errors.h>

namespace fumarole::study {
namespace {

// metrics.py's guards against 0/0 move results by this much at the magnitudes used here.
constexpr double kGuards = 2e-6;

std::vector<float> scaled(std::vector<float> values, float by)
{
    for (float& value : values) {
        value *= by;
    }
    return values;
}

const std::vector<float> kX = {1.0f, 2.5f, 0.0f, 4.5f, 7.0f, 0.25f};
const std::vector<float> kR = {1.5f, 2.0f, 0.0f, 5.0f, 6.0f, 0.5f};

TEST(Metrics, OfAPictureWithItselfAreZero)
{
    const Metrics m = compare(kR, kR);
    EXPECT_TRUE(m.finite);
    EXPECT_EQ(m.relmse, 0);
    EXPECT_EQ(m.smape, 0);
    EXPECT_EQ(m.bias, 0);
    EXPECT_EQ(m.p999, 0);
}

TEST(Metrics, HaveTheirHandWorkedValues)
{
    const std::vector<float> x = {1, 3};
    const std::vector<float> r = {2, 2};
    const Metrics m = compare(x, r);
    // Errors -1 and 1; mean(r) = 2, mean(r^2) = 4.
    EXPECT_NEAR(m.relmse, 1 / 4.4, kGuards);                 // both 1 / (4 + 0.4)
    EXPECT_NEAR(m.smape, (2.0 / 3 + 2.0 / 5) / 2, kGuards);  // 2 |x-r| / (|x| + |r|)
    EXPECT_NEAR(m.bias, 0, kGuards);
    EXPECT_NEAR(m.p999, 0.5, kGuards);  // 1 over mean 2
}

TEST(Metrics, BiasIsSigned)
{
    const std::vector<float> r = {1, 3};
    EXPECT_NEAR(compare(std::vector<float>{1.5f, 3.5f}, r).bias, 0.25, kGuards);
    EXPECT_NEAR(compare(std::vector<float>{0.5f, 2.5f}, r).bias, -0.25, kGuards);
}

TEST(Metrics, HighPercentileLiesBetweenRanksAsNumpysDoes)
{
    // 0..100 of 101 errors: rank 99.9, nine tenths of the way from 99 to 100; mean(r) = 1.
    std::vector<float> x;
    for (int i = 0; i <= 100; ++i) {
        x.push_back(1.0f + static_cast<float>((i * 37) % 101));
    }
    const std::vector<float> r(x.size(), 1.0f);
    EXPECT_NEAR(compare(x, r).p999, 99.9, 1e-9);

    // 1001 values: rank 999 exactly, so one outlier in a thousand does not count.
    std::vector<float> outlier(1001, 1.0f);
    outlier[500] = 1e6f;
    EXPECT_EQ(compare(outlier, std::vector<float>(1001, 1.0f)).p999, 0);
}

TEST(Metrics, AreBlindToTheScaleOfBothPictures)
{
    const Metrics m = compare(kX, kR);
    for (const float scale : {0.125f, 16.0f, 1024.0f}) {  // powers of two: no rounding of their own
        const Metrics s = compare(scaled(kX, scale), scaled(kR, scale));
        EXPECT_NEAR(s.relmse, m.relmse, 1e-12);
        EXPECT_NEAR(s.smape, m.smape, 1e-5);  // its guard is absolute
        EXPECT_NEAR(s.bias, m.bias, 1e-12);
        EXPECT_NEAR(s.p999, m.p999, 1e-12);
    }
}

TEST(Metrics, AreBlindToTheOrderOfValues)
{
    const Metrics m = compare(kX, kR);
    const Metrics s = compare(std::vector<float>(kX.rbegin(), kX.rend()),
                              std::vector<float>(kR.rbegin(), kR.rend()));
    EXPECT_NEAR(s.relmse, m.relmse, 1e-15);
    EXPECT_NEAR(s.smape, m.smape, 1e-15);
    EXPECT_NEAR(s.bias, m.bias, 1e-15);
    EXPECT_EQ(s.p999, m.p999);
}

TEST(Metrics, RelmseIsRelativeWhereBrightAndAbsoluteWhereDark)
{
    // The same error on the bright and on the dark pixel; mean(r^2) = 50, so 0.1 of it is 5.
    const std::vector<float> r = {10, 0};
    EXPECT_NEAR(compare(std::vector<float>{11, 0}, r).relmse, 0.5 / 105, kGuards);
    EXPECT_NEAR(compare(std::vector<float>{10, 1}, r).relmse, 0.5 / 5, kGuards);
}

TEST(Metrics, SumInDoublePrecision)
{
    // 2^24 + 1 ones: a float sum stops counting at 2^24. One error of 1 among them.
    std::vector<float> r((std::size_t{1} << 24) + 64, 1.0f);
    std::vector<float> x = r;
    x.back() = 65.0f;
    EXPECT_NEAR(compare(x, r).bias * static_cast<double>(r.size()), 64.0, 1e-6);
}

TEST(Metrics, ABlackReferenceDividesByNothing)
{
    const std::vector<float> black(8, 0.0f);
    const Metrics same = compare(black, black);
    EXPECT_EQ(same.relmse, 0);
    EXPECT_EQ(same.smape, 0);
    EXPECT_EQ(same.bias, 0);
    EXPECT_EQ(same.p999, 0);
    EXPECT_TRUE(std::isfinite(compare(std::vector<float>(8, 1.0f), black).relmse));
}

TEST(Metrics, ANonFinitePictureIsInfinitelyFar)
{
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity()}) {
        std::vector<float> x = kX;
        x[3] = bad;
        const Metrics m = compare(x, kR);
        EXPECT_FALSE(m.finite);
        for (const double value : {m.relmse, m.smape, m.bias, m.p999}) {
            EXPECT_EQ(value, std::numeric_limits<double>::infinity());
        }
    }
}

TEST(Metrics, NothingIsMeasuredAgainstABrokenReference)
{
    std::vector<float> r = kR;
    r[2] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(compare(kX, r), Error);
}

TEST(Metrics, LengthsMustAgree)
{
    EXPECT_THROW(compare(kX, std::vector<float>(5, 1.0f)), Error);
    EXPECT_THROW(compare(std::vector<float>{}, std::vector<float>{}), Error);
}

TEST(MaskedMetrics, CountOnlyWhatIsKept)
{
    // Three pixels of two channels; the middle one is wildly wrong, and not even a number.
    std::vector<float> x = kX;
    std::vector<float> r = kR;
    x[2] = 1e9f;
    x[3] = std::numeric_limits<float>::quiet_NaN();
    r[3] = std::numeric_limits<float>::quiet_NaN();
    const std::vector<std::uint8_t> keep = {1, 0, 255};
    const Metrics masked = compare(x, r, keep, 2);
    const Metrics rest = compare(std::vector<float>{kX[0], kX[1], kX[4], kX[5]},
                                 std::vector<float>{kR[0], kR[1], kR[4], kR[5]});
    EXPECT_TRUE(masked.finite);
    EXPECT_EQ(masked.relmse, rest.relmse);
    EXPECT_EQ(masked.smape, rest.smape);
    EXPECT_EQ(masked.bias, rest.bias);
    EXPECT_EQ(masked.p999, rest.p999);
}

TEST(MaskedMetrics, KeepingAllChangesNothing)
{
    const Metrics masked = compare(kX, kR, std::vector<std::uint8_t>{1, 1}, 3);
    EXPECT_EQ(masked.relmse, compare(kX, kR).relmse);
}

TEST(MaskedMetrics, TheMaskMustFitAndKeepSomething)
{
    EXPECT_THROW(compare(kX, kR, std::vector<std::uint8_t>{1, 1}, 2), Error);
    EXPECT_THROW(compare(kX, kR, std::vector<std::uint8_t>{}, 0), Error);
    EXPECT_THROW(compare(kX, kR, std::vector<std::uint8_t>{0, 0}, 3), Error);
}

}  // namespace
}  // namespace fumarole::study
