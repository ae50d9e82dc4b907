#include "study/reference_state.h"

#include <atomic>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <string>
#include <vector>

#include "study/reference_cache.h"
#include "support/reference_scenes.h"
#include "support/temp_folder.h"
#include "write/whole_file.h"

// A reference that is interrupted and gone on with is the one that never was.

namespace fumarole::study {
namespace {

using test::TempFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Told {
    std::vector<std::string> lines;

    ReferenceState state(const std::filesystem::path& file, ReferenceFacts facts = {{"it", "1"}})
    {
        return {file, std::move(facts), [this](const std::string& line) { lines.push_back(line); }};
    }
};

/// Of two tiles.
ReferenceOptions coarse()
{
    ReferenceOptions options;
    options.tolerance = 0.2;
    options.bounces = 1;
    return options;
}

/// Renders until a tile is done. @returns the share that is kept
double begin_reference(const Scene& scene, const ReferenceState& state)
{
    std::atomic<bool> cancel = false;
    ReferenceOptions options = coarse();
    options.cancel = &cancel;
    options.on_tile = [&](const auto&, const auto&) { cancel = true; };
    // With more, the other tile might be done as well.
    const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
    try {
        resume_reference(scene, options, state);
    } catch (const ReferenceCancelled& cancelled) {
        return cancelled.kept;
    }
    return 1;
}

void expect_same_bits(const ReferenceStill& a, const ReferenceStill& b)
{
    EXPECT_EQ(a.composite, b.composite);
    EXPECT_EQ(a.scattering, b.scattering);
    EXPECT_EQ(a.transmittance, b.transmittance);
    EXPECT_EQ(a.surface, b.surface);
    EXPECT_EQ(a.surface_lit, b.surface_lit);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.error, b.error);
    EXPECT_EQ(a.noise, b.noise);
    EXPECT_EQ(a.scattering_noise, b.scattering_noise);
}

class ReferenceStates : public testing::Test {
protected:
    TempFolder folder_;
    const std::filesystem::path file_ = reference_state_file(folder_.path() / "x.exr");
    const Scene scene_ = blob_scene();
};

TEST_F(ReferenceStates, OneThatWasInterruptedGoesOnToTheSameBits)
{
    const ReferenceStill whole = render_reference(scene_, coarse());
    for (const std::size_t threads : {1, 4}) {
        Told told;
        const ReferenceState state = told.state(file_);
        const double kept = begin_reference(scene_, state);
        ASSERT_GT(kept, 0.1);
        ASSERT_LT(kept, 0.9);
        EXPECT_THAT(told.lines, IsEmpty());
        const oneapi::tbb::global_control limit(
            oneapi::tbb::global_control::max_allowed_parallelism, threads);
        const ResumedReference resumed = resume_reference(scene_, coarse(), state);
        EXPECT_EQ(resumed.resumed, kept);
        EXPECT_THAT(told.lines, ElementsAre(HasSubstr("goes on from")));
        expect_same_bits(resumed.still, whole);
        EXPECT_TRUE(std::filesystem::remove(file_)) << "it is there until the picture is safe";
    }
}

TEST_F(ReferenceStates, PixelsThatWereFinishedAreTakenAsTheyAre)
{
    PartialReference begun{render_reference(scene_, coarse()), {}};
    begun.finished.assign(begun.still.depth.size(), 0);
    begun.finished[5] = 1;
    begun.still.depth.assign(begun.still.depth.size(), -1.0f);
    ReferenceOptions options = coarse();
    options.begun = &begun;
    const ReferenceStill still = render_reference(scene_, options);
    EXPECT_EQ(still.depth[5], -1.0f);
    EXPECT_GT(still.depth[4], 0.0f);
}

TEST_F(ReferenceStates, OneOfAnotherSceneBeginsAnewAndSaysWhatDiffers)
{
    const auto facts = [](const Scene& scene, const ReferenceOptions& options) {
        return reference_facts(scene, options, "1");
    };
    Scene other = scene_;
    other.media.clear();  // its grid is in no file
    Scene moved = other;
    moved.camera.position.x += 1;
    ReferenceOptions options = coarse();
    Told told;
    ASSERT_GT(begin_reference(scene_, told.state(file_, facts(other, options))), 0);
    const std::string before = write::read_whole(file_);
    options.tolerance = 0.3;
    options.bounces = kAllBounces;
    const ResumedReference anew =
        resume_reference(scene_, coarse(), told.state(file_, facts(moved, options)));
    EXPECT_EQ(anew.resumed, 0);
    ASSERT_EQ(told.lines.size(), 1u);
    for (const char* part :
         {"x.exr.unfinished", "--tolerance was 0.2 and is 0.3", "--bounces was 1 and is all",
          "the scene's camera changed", "begins anew", "10 s"})
        EXPECT_THAT(told.lines[0], HasSubstr(part));
    EXPECT_THAT(told.lines[0], Not(HasSubstr("lights")));
    EXPECT_THAT(told.lines[0], Not(HasSubstr("--aa")));
    EXPECT_EQ(write::read_whole(file_), before) << "left alone at first";
    expect_same_bits(anew.still, render_reference(scene_, coarse()));
}

TEST_F(ReferenceStates, OneThatIsDamagedIsNotTrusted)
{
    const ReferenceStill whole = render_reference(scene_, coarse());
    Told begun;
    ASSERT_GT(begin_reference(scene_, begun.state(file_)), 0);
    const std::string good = write::read_whole(file_);
    std::vector<std::string> damaged{"", "nonsense", good.substr(0, 40),
                                     good.substr(0, good.size() / 2), good + "x"};
    for (std::size_t at = 0; at < good.size(); at += good.size() / 6) {
        damaged.push_back(good);
        damaged.back()[at] ^= 4;
    }
    for (const std::string& bytes : damaged) {
        write::write_whole(file_, bytes);
        Told told;
        const ResumedReference resumed = resume_reference(scene_, coarse(), told.state(file_));
        EXPECT_THAT(told.lines,
                    ElementsAre(testing::AllOf(HasSubstr("x.exr.unfinished"), HasSubstr("damaged"),
                                               HasSubstr("begins anew"))));
        EXPECT_EQ(resumed.resumed, 0);
        expect_same_bits(resumed.still, whole);
    }
}

TEST_F(ReferenceStates, ThatTheFileCantBeWrittenEndsNothing)
{
    Told told;
    const ReferenceState state = told.state(folder_.path() / "none" / "x.exr.unfinished");
    EXPECT_EQ(begin_reference(scene_, state), 0);
    EXPECT_THAT(told.lines, ElementsAre(HasSubstr("no such folder")));
}

TEST_F(ReferenceStates, AKeptReferenceGoesOnToo)
{
    Scene scene = scene_;
    scene.media.clear();
    ReferenceOptions options = coarse();
    options.surface_bounces = 1;
    const auto ignore = [](const std::string&) {};
    const KeptReference whole = keep_reference(scene, options, folder_.path(), "1", ignore);
    ASSERT_TRUE(std::filesystem::remove(whole.file));
    std::atomic<bool> cancel = false;
    ReferenceOptions cut = options;
    cut.cancel = &cancel;
    cut.on_tile = [&](const auto&, const auto&) { cancel = true; };
    {
        const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism,
                                              1);
        EXPECT_THROW(keep_reference(scene, cut, folder_.path(), "1", ignore), ReferenceCancelled);
    }
    const std::filesystem::path state = reference_state_file(whole.file);
    EXPECT_TRUE(std::filesystem::exists(state));
    std::string told;
    const KeptReference resumed = keep_reference(scene, options, folder_.path(), "1",
                                                 [&](const std::string& line) { told = line; });
    EXPECT_THAT(told, HasSubstr("goes on from"));
    expect_same_bits(resumed.still, whole.still);
    EXPECT_TRUE(std::filesystem::exists(whole.file));
    EXPECT_FALSE(std::filesystem::exists(state)) << "gone once the reference is whole";
}

}  // namespace
}  // namespace fumarole::study
