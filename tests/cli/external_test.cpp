// Real files of many makers (Houdini, Blender, Bifrost, old versions, NanoVDB, damaged ones): each
// renders to a picture or is refused in one line. They lie beside the repository; without them
// nothing is tested.

#include <cmath>
#include <gtest/gtest.h>

#include "cli/run_program.h"
#include <fumarole/write/image_writer.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

TEST(External, RendersOrIsRefusedInOneLine)
{
    const fs::path external = fs::path(FUM_TEST_SHARED) / "vdb/external";
    if (!fs::exists(external))
        GTEST_SKIP() << external << " is not there";
    const TempFolder folder;
    std::vector<Arguments> commands;
    for (const auto& entry : fs::directory_iterator(external)) {
        const fs::path& file = entry.path();
        if (file.extension() != ".vdb" && file.extension() != ".nvdb")
            continue;
        commands.push_back(with_little_light({"render", "--aa=1", file.string(), "--size=96x54"}));
        commands.back().insert(commands.back().end(), {"-o", file.filename().string() + ".exr"});
    }
    ASSERT_GT(commands.size(), 10u);
    const std::vector<Outcome> runs = run_all(folder.path(), commands);
    std::size_t drawn = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const Outcome& run = runs[i];
        const std::string name = fs::path(commands[i][2]).filename();
        const fs::path picture = folder.path() / commands[i].back();
        if (run.code != 0) {
            EXPECT_EQ(run.code, 1) << name << '\n' << run;
            EXPECT_EQ(run.error_lines(), 1) << name << '\n' << run;
            EXPECT_NE(run.err.find(name), std::string::npos) << run;
            EXPECT_FALSE(fs::exists(picture)) << name;
            continue;
        }
        ++drawn;
        EXPECT_EQ(run.err, "") << name;
        const Image image = write::read_exr(picture, {"transmittance.G", "scattering.G", "G"});
        float least = 1, most = 0, lit = 0;
        for (std::size_t p = 0; p < image.pixels.size(); p += 3) {
            ASSERT_TRUE(std::isfinite(image.pixels[p + 2])) << name;
            least = std::min(least, image.pixels[p]);
            most = std::max(most, image.pixels[p]);
            lit = std::max(lit, image.pixels[p + 1]);
        }
        EXPECT_LT(least, 0.8f) << name << ": nothing to be seen";
        EXPECT_EQ(most, 1) << name << ": it fills the whole picture";
        EXPECT_GT(lit, 0.01f) << name << ": black";
    }
    EXPECT_GT(drawn, commands.size() / 2);
}

}  // namespace
}  // namespace fumarole::test
