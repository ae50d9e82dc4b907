#pragma once

#include <string_view>

#include <gtest/gtest.h>

#include <fumarole/write/image_writer.h>

namespace fumarole::test {

/// Use as `EXPECT_TRUE(images_near(actual, expected, 2e-3, 1e-4, "fp16 layer: 11 bits"))`.
///
/// Succeeds if size and channels are the same, all values are finite, no |actual - expected| is
/// over `max_abs` and their mean over all values is not over `mean_abs` (both in the pictures' own
/// unit). `reason` says why the tolerances are what they are, and is printed beside them.
///
/// A failure says which bound broke, where the worst pixel is, and draws where the pictures differ;
/// `<test>_actual.exr`, `<test>_expected.exr` and `<test>_difference_x10.exr` go to the folder in
/// the environment variable FUM_TEST_OUT, or to `test_failures` in the working folder (ctest: the
/// build tree).
[[nodiscard]] ::testing::AssertionResult images_near(const Image& actual, const Image& expected,
                                                     double max_abs, double mean_abs,
                                                     std::string_view reason);

}  // namespace fumarole::test
