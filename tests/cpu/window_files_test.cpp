// The window's files: what a folder holds, and small pictures of it that desktops share.

#include <chrono>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <thread>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "support/temp_folder.h"
#include "window/file_browser.h"
#include "window/file_list.h"
#include "window/thumbnail_files.h"
#include "window/thumbnail_maker.h"
#include "write/png_text.h"
#include <fumarole/asset/animation.h>
#include <fumarole/errors.h>

namespace fumarole::window {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> lines_of(const std::vector<FileEntry>& entries)
{
    std::vector<std::string> lines;
    for (const FileEntry& entry : entries)
        lines.push_back(
            entry.kind == FileEntry::Kind::sequence
                ? fmt::format("{} {}..{} {}", entry.name, entry.first, entry.last, entry.frames)
                : entry.name);
    return lines;
}

TEST(FileList, HasFoldersVolumesScenesAndSequencesInAPersonsOrder)
{
    const TempFolder folder;
    fs::create_directory(folder.path() / "zeta");
    fs::create_directory(folder.path() / ".hidden");
    for (const char* name : {"smoke_0001.vdb", "smoke_0002.vdb", "smoke_0004.vdb", "fire.10.nvdb",
                             "fire.9.nvdb", "fire.11.nvdb", "cloud_v1.vdb", "cloud_v2.vdb",
                             "take10.vdb", "take9.vdb", "B.VDB", "notes.txt", ".secret.vdb",
                             "shot3_0001_v2.vdb", "shot3_0002_v2.vdb", "shot3_0003_v2.vdb"})
        folder.write(name, "x");
    folder.write("scene.json", R"({"media": []})");
    folder.write("broken.json", R"({"media": [)");
    folder.write("package.json", R"({"name": "x"})");
    const std::vector<FileEntry> entries = list_folder(folder.path());
    EXPECT_THAT(lines_of(entries),
                ElementsAre("zeta", "B.VDB", "broken.json", "cloud_v1.vdb", "cloud_v2.vdb",
                            "fire.#.nvdb 9..11 3", "scene.json", "shot3_####_v2.vdb 1..3 3",
                            "smoke_####.vdb 1..4 3", "take9.vdb", "take10.vdb"));
    EXPECT_EQ(describe(entries[8]), "frames 1..4 (3), 1 kB");
    EXPECT_EQ(entries[8].pictured, (folder.path() / "smoke_0002.vdb").string());
    // What is opened is what the readers take for the same frames.
    EXPECT_THAT(frames_of(entries[8].path), ElementsAre(1, 2, 4));
    EXPECT_THAT(frames_of(entries[5].path), ElementsAre(9, 10, 11));
    EXPECT_TRUE(is_sequence(entries[7].path));
    EXPECT_THROW(list_folder(folder.path() / "none"), Error);
}

// Of RFC 1321, A.5, and of lengths about a block's end.
TEST(ThumbnailFiles, AreCalledByTheMd5OfTheirUri)
{
    EXPECT_EQ(md5(""), "d41d8cd98f00b204e9800998ecf8427e");
    EXPECT_EQ(md5("abc"), "900150983cd24fb0d6963f7d28e17f72");
    EXPECT_EQ(
        md5("12345678901234567890123456789012345678901234567890123456789012345678901234567890"),
        "57edf4a22be3c955ac49da2e2107b67a");
    EXPECT_EQ(md5(std::string(55, 'a')), "ef1772b6dff9a122358552954ad0df65");
    EXPECT_EQ(md5(std::string(56, 'a')), "3b0c8ac703f828b04c6c197006d17218");
    // As the standard has it of this one.
    EXPECT_EQ(md5("file:///home/jens/photos/me.png"), "c6ee772d9e49320e97ec29a7eb5b1697");
    EXPECT_EQ(file_uri("/a b/f\xc3\xa9u#1.vdb"), "file:///a%20b/f%C3%A9u%231.vdb");
}

Image gray(int width, int height)
{
    Image image;
    image.width = width;
    image.height = height;
    image.channels = {"R", "G", "B"};
    image.pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3,
                        0.18f);
    return image;
}

TEST(ThumbnailFiles, APictureIsOfItsFileUntilThatChanges)
{
    const TempFolder folder;
    const ThumbnailCache cache(folder.path() / "cache/thumbnails");
    const fs::path file = folder.write("a.vdb", "12345");
    EXPECT_FALSE(cache.find(file).known());
    const fs::path place = cache.place_for(file);
    EXPECT_EQ(place.filename(), md5(file_uri(file)) + ".png");
    EXPECT_EQ(place.parent_path().filename(), "large");
    struct stat about {};
    ASSERT_EQ(stat(place.parent_path().c_str(), &about), 0);
    EXPECT_EQ(about.st_mode & 0777U, 0700U);
    write::write_png(gray(8, 6), {}, place, thumbnail_texts(file));
    Thumbnail found = cache.find(file);
    EXPECT_EQ(found.picture.width, 8);
    EXPECT_EQ(found.picture.height, 6);
    ASSERT_EQ(found.picture.rgba.size(), 8u * 6 * 4);
    EXPECT_EQ(found.picture.rgba[3], 255);
    EXPECT_NEAR(found.picture.rgba[0], 117, 1);
    EXPECT_EQ(found.picture.texts.at("Thumb::URI"), file_uri(file));
    EXPECT_EQ(found.picture.texts.at("Thumb::Size"), "5");
    fs::last_write_time(file, fs::last_write_time(file) - std::chrono::seconds(10));
    EXPECT_FALSE(cache.find(file).known());
    cache.keep_error(file, "torn at byte 3, f\xc3\xa9u");
    EXPECT_EQ(cache.find(file).error, "torn at byte 3, f\xc3\xa9u");
    folder.write("a.vdb", "123456");
    EXPECT_FALSE(cache.find(file).known());
    // What is no picture is none.
    folder.write("bad.png", "\x89PNG\r\n\x1a\nxxxxxxxxxxxxxxxxx");
    EXPECT_FALSE(read_thumbnail(folder.path() / "bad.png"));
    EXPECT_FALSE(read_thumbnail(folder.path() / "none.png"));
}

/// Waits for the pictures of so many files.
std::vector<ThumbnailMaker::Made> wait_for(ThumbnailMaker& maker, std::size_t count)
{
    std::vector<ThumbnailMaker::Made> all;
    for (int i = 0; i < 6000 && all.size() < count; ++i) {
        for (ThumbnailMaker::Made& made : maker.take())
            all.push_back(std::move(made));
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return all;
}

/// A program in fumarole's stead: `bad.vdb` fails, `dead.vdb` kills it, `slow.vdb` never ends,
/// others are given picture.png. It counts its runs.
fs::path write_program(const TempFolder& folder)
{
    const fs::path program = folder.write(
        "program",
        "#!/bin/sh\n"
        "echo run >> \"" +
            (folder.path() / "runs").string() +
            "\"\n"
            "case \"$5\" in\n"
            "*bad.vdb) echo note >&2; echo \"fumarole: $5: no tree at byte 12\" >&2; exit 1;;\n"
            "*dead.vdb) kill -SEGV $$;;\n"
            "*slow.vdb) exec sleep 1000;;\n"
            "esac\n"
            "cp \"$5.png\" \"$6.tmp\" && mv \"$6.tmp\" \"$6\"\n");
    fs::permissions(program, fs::perms::owner_all);
    return program;
}

TEST(ThumbnailMaker, MakesEachPictureOnceAndKeepsWhatIsWrong)
{
    const TempFolder folder;
    const ThumbnailCache cache(folder.path() / "thumbnails");
    const fs::path good = folder.write("good.vdb", "g"), bad = folder.write("bad.vdb", "b"),
                   dead = folder.write("dead.vdb", "d");
    write::write_png(gray(4, 3), {}, good.string() + ".png", thumbnail_texts(good));
    const auto make = [&] {
        ThumbnailMaker maker(write_program(folder), cache);
        maker.want({good.string(), bad.string(), dead.string()});
        return wait_for(maker, 3);
    };
    std::vector<ThumbnailMaker::Made> made = make();
    ASSERT_EQ(made.size(), 3u);
    EXPECT_EQ(made[0].thumbnail.picture.width, 4);
    EXPECT_EQ(made[0].thumbnail.error, "");
    EXPECT_EQ(made[1].thumbnail.error, "no tree at byte 12");
    EXPECT_THAT(made[2].thumbnail.error, HasSubstr("can't be made"));
    struct stat about {};
    ASSERT_EQ(stat(cache.place_for(good).c_str(), &about), 0);
    EXPECT_EQ(about.st_mode & 0777U, 0600U);
    EXPECT_EQ(test::read_bytes(folder.path() / "runs"), "run\nrun\nrun\n");
    made = make();
    EXPECT_EQ(made[1].thumbnail.error, "no tree at byte 12");
    EXPECT_EQ(test::read_bytes(folder.path() / "runs"), "run\nrun\nrun\n") << "all is kept";
    folder.write("bad.vdb", "mended");
    fs::last_write_time(bad, fs::last_write_time(bad) + std::chrono::seconds(10));
    make();
    EXPECT_EQ(test::read_bytes(folder.path() / "runs"), "run\nrun\nrun\nrun\n");
}

TEST(ThumbnailMaker, NobodyWaitsForAProgramThatDoesNotEnd)
{
    const TempFolder folder;
    const fs::path slow = folder.write("slow.vdb", "s");
    const auto begin = std::chrono::steady_clock::now();
    {
        ThumbnailMaker maker(write_program(folder), ThumbnailCache(folder.path() / "thumbnails"));
        maker.want({slow.string()});
        for (int i = 0; i < 2000 && !fs::exists(folder.path() / "runs"); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        EXPECT_TRUE(maker.take().empty());
    }
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
    EXPECT_FALSE(ThumbnailCache(folder.path() / "thumbnails").find(slow).known())
        << "it was stopped, and is not known to be bad";
}

class FileBrowserTest : public testing::Test {
protected:
    FileBrowserTest()
    {
        fs::create_directories(folder_.path() / "shots/a");
        fs::create_directories(folder_.path() / "shots/b");
        for (const char* name : {"shots/c.vdb", "shots/d.vdb", "shots/bad.vdb"})
            folder_.write(name, "x");
    }
    void settle()
    {
        for (int i = 0; i < 6000; ++i) {
            browser_.take_read();
            if (!browser_.listing()) {
                browser_.take_read();
                return;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    }
    void press(int key) { EXPECT_TRUE(browser_.take_key({key, true, {}})); }
    [[nodiscard]] std::string chosen() const
    {
        return browser_.entries().at(browser_.chosen()).name;
    }

    TempFolder folder_;
    FileBrowser browser_{write_program(folder_), ThumbnailCache(folder_.path() / "thumbnails")};
};

TEST_F(FileBrowserTest, IsLookedThroughByKeys)
{
    EXPECT_FALSE(browser_.take_key({GLFW_KEY_ENTER, true, {}})) << "it is not open";
    browser_.open((folder_.path() / "shots").string() + "/");
    EXPECT_EQ(browser_.folder(), (folder_.path() / "shots").string());
    settle();
    EXPECT_THAT(lines_of(browser_.entries()), ElementsAre("a", "b", "bad.vdb", "c.vdb", "d.vdb"));
    browser_.set_layout(2, 1);
    press(GLFW_KEY_DOWN);
    EXPECT_EQ(chosen(), "bad.vdb");
    press(GLFW_KEY_RIGHT);
    press(GLFW_KEY_RIGHT);
    EXPECT_EQ(chosen(), "d.vdb");
    press(GLFW_KEY_UP);
    EXPECT_EQ(chosen(), "bad.vdb");
    press(GLFW_KEY_B);
    EXPECT_EQ(chosen(), "b");
    press(GLFW_KEY_C);
    EXPECT_EQ(chosen(), "c.vdb");
    press(GLFW_KEY_HOME);
    press(GLFW_KEY_RIGHT);
    press(GLFW_KEY_ENTER);
    settle();
    EXPECT_EQ(browser_.folder(), (folder_.path() / "shots/b").string());
    EXPECT_TRUE(browser_.entries().empty());
    press(GLFW_KEY_BACKSPACE);
    settle();
    EXPECT_EQ(chosen(), "b") << "where one came from";
    EXPECT_EQ(browser_.taken(), "");
    press(GLFW_KEY_END);
    press(GLFW_KEY_ENTER);
    EXPECT_EQ(browser_.taken(), (folder_.path() / "shots/d.vdb").string());
    EXPECT_FALSE(browser_.is_open());
    browser_.open("");
    settle();
    EXPECT_EQ(chosen(), "d.vdb") << "where it was left";
    press(GLFW_KEY_ESCAPE);
    EXPECT_FALSE(browser_.is_open());
}

TEST_F(FileBrowserTest, HasPicturesOfWhatIsSeenAlone)
{
    browser_.open((folder_.path() / "shots").string());
    settle();
    EXPECT_FALSE(browser_.settled()) << "nothing was seen yet";
    browser_.show(0, 3);
    for (int i = 0; i < 6000 && !browser_.settled(); ++i) {
        browser_.take_read();
        browser_.show(0, 3);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_TRUE(browser_.settled());
    EXPECT_EQ(browser_.thumbnail(browser_.entries()[2]).error, "no tree at byte 12");
    EXPECT_FALSE(browser_.thumbnail(browser_.entries()[3]).known());
    EXPECT_EQ(test::read_bytes(folder_.path() / "runs"), "run\n");
}

TEST_F(FileBrowserTest, SaysWhyAFolderCannotBeRead)
{
    browser_.open((folder_.path() / "none").string());
    settle();
    EXPECT_THAT(browser_.error(), HasSubstr("none: No such file"));
    browser_.take_path(folder_.path().string());
    settle();
    EXPECT_EQ(browser_.error(), "");
}

}  // namespace
}  // namespace fumarole::window
