#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "window/background.h"
#include "window/event.h"
#include "window/file_list.h"
#include "window/thumbnail_maker.h"

namespace fumarole::window {

/// The folder that is looked through for a file to open: its entries, their small pictures, and
/// which is chosen. Folders and pictures are read on threads of their own.
class FileBrowser {
public:
    /// Pictures that are kept beside those that are seen.
    static constexpr std::size_t kMostPictures = 256;

    FileBrowser(std::filesystem::path program, ThumbnailCache cache);

    [[nodiscard]] bool is_open() const { return open_; }
    /// Shows a folder, or the one that was shown last if that is "".
    void open(const std::string& folder);
    void close();
    /// Takes what was read since the last call.
    void take_read();

    /// Absolute; "" before one was shown.
    [[nodiscard]] const std::string& folder() const { return folder_; }
    [[nodiscard]] const std::vector<FileEntry>& entries() const { return entries_; }
    [[nodiscard]] bool listing() const { return listing_.busy(); }
    /// Why the folder can't be read, or "".
    [[nodiscard]] const std::string& error() const { return error_; }
    /// What is known of an entry's picture.
    [[nodiscard]] const Thumbnail& thumbnail(const FileEntry& entry) const;

    [[nodiscard]] bool has(const std::string& pictured) const
    {
        return thumbnails_.contains(pictured);
    }

    /// Says which entries are seen, of which pictures are then made.
    void show(std::size_t first, std::size_t last);
    /// Whether the folder has been read, and all that is seen has its picture or its error.
    [[nodiscard]] bool settled() const;

    [[nodiscard]] std::size_t chosen() const { return chosen_; }
    void choose(std::size_t entry);
    /// Goes into a folder, or takes a file to be opened and closes.
    void take(std::size_t entry);
    void take_path(const std::string& path);
    void go_up();
    /// Does what a key does here. Returns whether it does something.
    bool take_key(const KeyEvent& key);
    /// The file that was taken since the last call, or "".
    std::string taken() { return std::exchange(taken_, ""); }
    /// Whether the chosen entry has been changed by a key since the last call: it is to be seen.
    bool take_moved() { return std::exchange(moved_, false); }

    /// How the entries are laid out, for keys that go to a neighbour.
    void set_layout(std::size_t columns, std::size_t rows);

private:
    struct Shared {
        std::mutex lock;
        bool done = false;
        std::vector<FileEntry> entries;
        std::string error;
    };
    void move(std::ptrdiff_t by);
    void find_letter(char letter);

    bool open_ = false;
    std::string folder_, error_, taken_;
    std::string came_from_;  ///< the entry to choose once the folder is read
    std::vector<FileEntry> entries_;
    std::size_t chosen_ = 0, columns_ = 1, rows_ = 1;
    std::size_t first_seen_ = 0, last_seen_ = 0;
    bool moved_ = false, shown_ = false;
    std::map<std::string, Thumbnail> thumbnails_;
    std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
    Background listing_;
    ThumbnailMaker maker_;
};

}  // namespace fumarole::window
