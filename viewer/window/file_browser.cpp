#include "window/file_browser.h"

#include <algorithm>
#include <cctype>
#include <exception>
#include <filesystem>
#include <system_error>
#include <utility>

#include <GLFW/glfw3.h>

#include "window/glfw_window.h"

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;

std::string absolute_folder(const std::string& folder)
{
    std::error_code error;
    fs::path path = fs::absolute(folder.empty() ? "." : folder, error).lexically_normal();
    if (!path.has_filename() && path.has_relative_path())  // of `folder/`
        path = path.parent_path();
    return path.string();
}

}  // namespace

FileBrowser::FileBrowser(fs::path program, ThumbnailCache cache)
    : maker_{std::move(program), std::move(cache)}
{
}

void FileBrowser::open(const std::string& folder)
{
    open_ = true;
    const std::string next = folder.empty() && !folder_.empty() ? folder_ : absolute_folder(folder);
    // What has changed in it since is read anew, and seen from where it was looked at.
    if (next == folder_)
        came_from_ = chosen_ < entries_.size() ? entries_[chosen_].name : "";
    else
        entries_.clear();
    folder_ = next;
    error_.clear();
    chosen_ = 0;
    shown_ = false;
    thumbnails_.clear();
    maker_.want({});
    shared_ = std::make_shared<Shared>();
    listing_.run([next, shared = shared_](const Background::Stop&) {
        std::vector<FileEntry> entries;
        std::string error;
        try {
            entries = list_folder(next);
        } catch (const std::exception& failed) {
            error = failed.what();
        }
        const std::lock_guard lock(shared->lock);
        shared->entries = std::move(entries);
        shared->error = std::move(error);
        shared->done = true;
    });
}

void FileBrowser::close()
{
    open_ = false;
    maker_.want({});
    thumbnails_.clear();
}

void FileBrowser::take_read()
{
    {
        const std::lock_guard lock(shared_->lock);
        if (std::exchange(shared_->done, false)) {
            entries_ = std::move(shared_->entries);
            error_ = std::move(shared_->error);
            const auto from =
                std::find_if(entries_.begin(), entries_.end(),
                             [&](const FileEntry& entry) { return entry.name == came_from_; });
            chosen_ = from == entries_.end()
                          ? 0
                          : static_cast<std::size_t>(std::distance(entries_.begin(), from));
            came_from_.clear();
            moved_ = true;
            shown_ = false;
        }
    }
    for (ThumbnailMaker::Made& made : maker_.take())
        if (open_)
            thumbnails_[made.file] = std::move(made.thumbnail);
}

const Thumbnail& FileBrowser::thumbnail(const FileEntry& entry) const
{
    static const Thumbnail none;
    const auto there = thumbnails_.find(entry.pictured);
    return there == thumbnails_.end() ? none : there->second;
}

void FileBrowser::show(std::size_t first, std::size_t last)
{
    first_seen_ = first;
    last_seen_ = std::min(last, entries_.size());
    shown_ = !listing();
    std::vector<std::string> wanted;
    for (std::size_t i = first_seen_; i < last_seen_; ++i)
        if (!entries_[i].pictured.empty() && !thumbnail(entries_[i]).known())
            wanted.push_back(entries_[i].pictured);
    maker_.want(std::move(wanted));
    if (thumbnails_.size() <= kMostPictures)
        return;
    std::map<std::string, Thumbnail> seen;
    for (std::size_t i = first_seen_; i < last_seen_; ++i)
        if (const auto node = thumbnails_.extract(entries_[i].pictured); !node.empty())
            seen.emplace(node.key(), node.mapped());
    thumbnails_ = std::move(seen);
}

bool FileBrowser::settled() const
{
    if (!open_ || listing() || !shown_)
        return false;
    for (std::size_t i = first_seen_; i < std::min(last_seen_, entries_.size()); ++i)
        if (!entries_[i].pictured.empty() && !thumbnail(entries_[i]).known())
            return false;
    return true;
}

void FileBrowser::choose(std::size_t entry)
{
    chosen_ = entry < entries_.size() ? entry : 0;
}

void FileBrowser::take(std::size_t entry)
{
    if (entry < entries_.size())
        take_path(entries_[entry].path);
}

void FileBrowser::take_path(const std::string& path)
{
    if (path.empty())
        return;
    std::error_code unknown;
    const std::string there = (fs::path(folder_) / path).string();
    if (fs::is_directory(there, unknown)) {
        open(there);
        return;
    }
    taken_ = there;
    close();
}

void FileBrowser::go_up()
{
    const fs::path here(folder_);
    if (!here.has_relative_path())
        return;
    open(here.parent_path().string());
    came_from_ = here.filename().string();
}

void FileBrowser::set_layout(std::size_t columns, std::size_t rows)
{
    columns_ = std::max<std::size_t>(columns, 1);
    rows_ = std::max<std::size_t>(rows, 1);
}

void FileBrowser::move(std::ptrdiff_t by)
{
    if (entries_.empty())
        return;
    const auto last = static_cast<std::ptrdiff_t>(entries_.size()) - 1;
    chosen_ = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(chosen_) + by, 0, last));
    moved_ = true;
}

void FileBrowser::find_letter(char letter)
{
    for (std::size_t i = 1; i <= entries_.size(); ++i) {
        const std::size_t at = (chosen_ + i) % entries_.size();
        if (std::toupper(static_cast<unsigned char>(entries_[at].name.front())) == letter) {
            chosen_ = at;
            moved_ = true;
            return;
        }
    }
}

bool FileBrowser::take_key(const KeyEvent& key)
{
    if (!open_ || !key.down || key.modifiers.control || key.modifiers.alt)
        return false;
    const auto columns = static_cast<std::ptrdiff_t>(columns_),
               page = columns * static_cast<std::ptrdiff_t>(rows_),
               all = static_cast<std::ptrdiff_t>(entries_.size());
    switch (key.key) {
    case GLFW_KEY_LEFT:
        move(-1);
        return true;
    case GLFW_KEY_RIGHT:
        move(1);
        return true;
    case GLFW_KEY_UP:
        move(-columns);
        return true;
    case GLFW_KEY_DOWN:
        move(columns);
        return true;
    case GLFW_KEY_PAGE_UP:
        move(-page);
        return true;
    case GLFW_KEY_PAGE_DOWN:
        move(page);
        return true;
    case GLFW_KEY_HOME:
        move(-all);
        return true;
    case GLFW_KEY_END:
        move(all);
        return true;
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER:
        take(chosen_);
        return true;
    case GLFW_KEY_BACKSPACE:
        go_up();
        return true;
    case GLFW_KEY_ESCAPE:
        close();
        return true;
    default:
        break;
    }
    if ((key.key >= GLFW_KEY_A && key.key <= GLFW_KEY_Z) ||
        (key.key >= GLFW_KEY_0 && key.key <= GLFW_KEY_9))
        find_letter(static_cast<char>(key.key));
    return true;  // no other key does something to what is behind it
}

}  // namespace fumarole::window
