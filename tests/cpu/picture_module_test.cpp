// The module that the program opens for pictures, as the program opens it.

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "pictures/table.h"
#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole {
namespace {

TEST(PictureModule, WritesAndReadsAndItsErrorsAreOurs)
{
    const auto file = std::filesystem::path(FUM_PROGRAM).parent_path() / pictures::kModule;
    void* module = ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
    ASSERT_NE(module, nullptr) << ::dlerror();
    const auto get = reinterpret_cast<pictures::GetTable>(::dlsym(module, pictures::kGetTable));
    ASSERT_NE(get, nullptr);
    const pictures::Table& table = *get();
    const test::TempFolder folder;
    const auto exr = folder.path() / "a.exr", png = folder.path() / "a.png";
    const Image image{1, 1, {"R", "G", "B"}, {1, 2, 3}};
    table.write_exr(image, exr, {});
    EXPECT_EQ(table.read_exr(exr, {}).at(0, 0, 2), 3);
    EXPECT_EQ(table.load_environment(exr).radiance.at(0), glm::vec3(1, 2, 3));
    EXPECT_TRUE(table.is_whole(exr, {1, 1}));
    write::write_png(image, {}, png);
    EXPECT_EQ(table.load_image(png).width, 1);
    try {
        table.read_exr(png.parent_path() / "none.exr", {});
        FAIL() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("none.exr"), std::string::npos);
    }
}

}  // namespace
}  // namespace fumarole
