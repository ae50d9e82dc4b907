#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "window/background.h"
#include "window/grid_roles.h"
#include <fumarole/scene.h>

namespace fumarole::window {

/// What is known of the grids of one medium's file.
struct GridList {
    std::vector<GridRow> rows;
    bool listed = false;  ///< the file's headers were read, or could not be
    std::string error;    ///< why they could not, or why the last change could not be made, or ""
    std::string wrong;    ///< the grid whose change could not be made, or ""
};

/// The grids of the media's files: lists of them, and changes of what they are taken for. Files are
/// read on threads of their own.
class GridRouter {
public:
    /// A medium that has been given another part.
    struct Routed {
        std::size_t medium = 0;
        int frame = 0;  ///< that its grids are of
        GridMedium as;
        std::vector<std::string> notes;
    };

    /// Begins anew with the files of a scene. @param moving with the #s of its sequences
    void open(const Scene& moving);
    /// One list for each medium of the scene; a medium that has no file has an empty one.
    [[nodiscard]] const std::vector<GridList>& lists() const { return lists_; }
    /// Takes what was listed since the last call.
    void take_listed();

    /// Asks for a change. Changes are made in the order in which they were asked for.
    void ask(std::size_t medium, const std::string& grid, GridRole role);
    /// Begins with the next change, if none is under way: from what the scene is now.
    /// @param moving the scene with the #s of its sequences @param frame that is shown
    void follow(const Scene& moving, const Scene& shown, int frame);
    /// The change that was made since the last call, if one was. One that failed has left its
    /// reason in the medium's list.
    std::optional<Routed> take_routed();

    /// Whether lists are being read or changes made.
    [[nodiscard]] bool busy() const;
    [[nodiscard]] bool routing() const { return running_.has_value() || !waiting_.empty(); }
    /// What is being read for a change, or "".
    [[nodiscard]] std::string progress() const;

private:
    struct Asked {
        std::size_t medium;
        std::string grid;
        GridRole role;
    };
    struct Listed {
        std::string file;
        std::vector<GridRow> rows;
        std::string error;
    };
    /// State shared with the threads, which may still run after another scene was opened.
    struct Shared {
        std::mutex lock;
        std::vector<Listed> listed;
        std::optional<Routed> routed;
        std::string error;  ///< of the change
        bool done = false;  ///< with the change
    };

    static void read_lists(const std::vector<std::string>& files, Shared& shared,
                           const Background::Stop& stop);

    std::vector<GridList> lists_;
    std::vector<std::string> files_;  ///< of the media
    std::vector<RoleMemory> memory_;  ///< of the media
    std::deque<Asked> waiting_;
    std::optional<Asked> running_;
    std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
    Background listing_, routing_;
};

}  // namespace fumarole::window
