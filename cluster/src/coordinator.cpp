// The cluster backend: plans a frame, does its share and sees to it that the frame gets done.
#include <algorithm>
#include <atomic>
#include <cylpose/cluster/backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/gate.hpp>
#include <cylpose/locate.hpp>
#include <utility>

#include "cost_model.hpp"
#include "frame_work.hpp"
#include "share_judge.hpp"
#include "strips.hpp"
#include "tile_desk.hpp"

namespace cylpose::cluster {
namespace {

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// What all pieces of a frame have in common.
struct FrameTask {
  ImageView image;
  Roi search;
  std::span<const PartModel> parts;
  DetectOptions options;
  Clock::time_point start;
  [[nodiscard]] double pixels() const { return pixels_in({0, search.height}); }
  [[nodiscard]] double pixels_in(const Rows& rows) const {
    return static_cast<double>(search.width) * (rows.end - rows.first);
  }
};

class Coordinator final : public ClusterBackend {
 public:
  Coordinator(std::unique_ptr<Backend> local, const ClusterOptions& options)
      : local_(std::move(local)), options_(options), desk_(options) {}

  [[nodiscard]] std::string_view name() const override { return "cluster"; }
  [[nodiscard]] std::vector<ClusterNode> nodes() const override { return desk_.nodes(); }
  [[nodiscard]] ClusterCounters counters() const override { return desk_.counters(); }

  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    const FrameTask task{image, usable_search(image, search, options), parts, options, Clock::now()};
    const bool whole = options.locate && options.rows == Rows() && !options.with_mask;
    if (!whole || task.search.empty() || parts.empty() || parts.size() > kMostTileParts) return alone(task);
    const int most_rows = desk_.most_rows(task.search.width, image.format);
    const std::vector<TileDesk::NodeOffer> offers = most_rows > 0 ? desk_.offers() : std::vector<TileDesk::NodeOffer>();
    if (!options_.share_local && most_rows > 0) return remote(task, most_rows, offers.size());
    if (offers.empty()) return alone(task);
    const int rows = tile_rows(task, most_rows, 2 * (offers.size() + 1));
    const std::vector<Assignment> plan = planned(task, rows, offers);
    if (!plan.empty()) return shared(task, plan, offers);
    probe(task, rows, offers);
    return alone(task);
  }

 private:
  // Counts a frame for as long as it is under way.
  class Underway {
   public:
    explicit Underway(std::atomic<std::size_t>& frames) : count(++frames), frames_(frames) {}
    ~Underway() { --frames_; }
    Underway(const Underway&) = delete;
    Underway& operator=(const Underway&) = delete;
    const std::size_t count;  ///< this one included, when it began

   private:
    std::atomic<std::size_t>& frames_;
  };

  [[nodiscard]] int tile_rows(const FrameTask& task, int most_rows, std::size_t pieces) const {
    constexpr int kLeastRows = 32;  // halos make thinner tiles a waste
    const int count = static_cast<int>(std::max<std::size_t>(pieces, 1));
    const int wanted =
        options_.tile_rows > 0 ? options_.tile_rows : std::max(kLeastRows, (task.search.height + count - 1) / count);
    return std::min({wanted, most_rows, task.search.height});
  }

  [[nodiscard]] std::vector<Assignment> planned(const FrameTask& task, int rows,
                                                const std::vector<TileDesk::NodeOffer>& offers) {
    std::vector<Offer> costs;
    costs.reserve(offers.size());
    for (const TileDesk::NodeOffer& offer : offers) costs.push_back(offer.offer);
    const std::scoped_lock lock(mutex_);
    if (!judge_.allows_sharing()) return {};
    return worth_sending(task.search.height, task.search.width, rows, home_, costs);
  }

  // The local device does it all.
  EdgeField alone(const FrameTask& task) {
    EdgeField field = local_->detect(task.image, task.search, task.parts, task.options);
    const double ms = ms_since(task.start);
    if (!task.search.empty()) {
      const std::scoped_lock lock(mutex_);
      home_.local.add(task.pixels(), ms);
      judge_.alone(ms / task.pixels());
    }
    desk_.count_frame(false, 0);
    return field;
  }

  // Sends a tile that nobody waits for, so that its node's cost is known: of new nodes at once, of others now and then.
  void probe(const FrameTask& task, int rows, const std::vector<TileDesk::NodeOffer>& offers) {
    constexpr int kFramesBetween = 64;
    {
      const std::scoped_lock lock(mutex_);
      if (--frames_to_probe_ > 0) return;
      frames_to_probe_ = kFramesBetween;
    }
    const auto chosen = std::ranges::find(offers, false, &TileDesk::NodeOffer::probed);
    if (chosen == offers.end()) return;
    const std::scoped_lock lock(mutex_);
    small_probe_ = !small_probe_;  // two sizes tell the fixed from the growing part of the cost
    const int height = small_probe_ ? std::max(1, rows / 4) : rows;
    send(task, {0, height}, *chosen, nullptr, 0);
  }

  void send(const FrameTask& task, const Rows& rows, const TileDesk::NodeOffer& to,
            const std::shared_ptr<FrameWork>& work, std::size_t piece) {
    const Roi tall = with_halo(task.search, rows);
    const int halo_above = task.search.y + rows.first - tall.y;
    Tile tile;
    tile.image = cropped(task.image, tall);
    tile.rows = {halo_above, halo_above + rows.end - rows.first};
    tile.edge_low = task.options.edge_low;
    tile.edge_high = task.options.edge_high;
    tile.parts.assign(task.parts.begin(), task.parts.end());
    desk_.send(to.node, std::move(tile), tall, work, piece);
  }

  // Nodes do the lower rows, the local device the upper ones and then what nodes owe.
  EdgeField shared(const FrameTask& task, const std::vector<Assignment>& plan,
                   const std::vector<TileDesk::NodeOffer>& offers) {
    const auto work = std::make_shared<FrameWork>();
    if (plan.back().rows.first > 0) work->pieces.push_back({{0, plan.back().rows.first}, 0, 0, {}, false, {}});
    const std::size_t own = work->pieces.size();
    for (auto tile = plan.rbegin(); tile != plan.rend(); ++tile)
      work->pieces.push_back({tile->rows, 0, 0, {}, false, {}});
    for (std::size_t i = 0; i < plan.size(); ++i) {
      const auto sending = Clock::now();
      const std::size_t piece = own + plan.size() - 1 - i;
      send(task, plan[i].rows, offers[plan[i].offer], work, piece);
      const std::scoped_lock lock(mutex_);
      home_.sending.add(task.pixels_in(plan[i].rows), ms_since(sending));
    }
    const std::int64_t taken_back = finish(task, *work);
    EdgeField field = merged(task, *work);
    {
      const std::scoped_lock lock(mutex_);
      judge_.shared(ms_since(task.start) / task.pixels());
    }
    desk_.count_frame(true, taken_back);
    return field;
  }

  // Does locally what is not sent or overdue, until nothing is left.
  std::int64_t finish(const FrameTask& task, FrameWork& work) {
    const auto deadline = task.start + options_.deadline;
    std::int64_t taken_back = 0;
    std::unique_lock lock(work.mutex);
    while (!work.complete()) {
      const auto now = Clock::now();
      auto wake = deadline;
      Piece* ours = nullptr;
      for (Piece& piece : work.pieces) {
        if (piece.done) continue;
        if (piece.copies == 0 || piece.due <= now || deadline <= now) {
          ours = &piece;
          break;
        }
        wake = std::min(wake, piece.due);
      }
      if (ours == nullptr) {
        work.changed.wait_until(lock, wake);
        continue;
      }
      taken_back += ours->tries > 0 ? 1 : 0;
      do_locally(task, *ours, lock);
    }
    return taken_back;
  }

  void do_locally(const FrameTask& task, Piece& piece, std::unique_lock<std::mutex>& lock) {
    lock.unlock();
    const auto start = Clock::now();
    std::vector<PartEdges> parts = detect_strip(*local_, task.image, task.search, piece.rows, task.parts, task.options);
    const double ms = ms_since(start);
    {
      const std::scoped_lock own_lock(mutex_);
      home_.local.add(task.pixels_in(piece.rows), ms);
    }
    lock.lock();
    static_cast<void>(FrameWork::deliver(piece, std::move(parts)));
  }

  // Nodes do everything that they can do before the deadline. Frames that are under way at once occupy nodes as well as
  // the tiles of one do, and without halos.
  EdgeField remote(const FrameTask& task, int most_rows, std::size_t nodes) {
    const Underway underway(frames_underway_);
    const int rows = tile_rows(task, most_rows, nodes / underway.count);
    const auto work = std::make_shared<FrameWork>();
    for (int first = 0; first < task.search.height; first += rows) {
      work->pieces.push_back({{first, std::min(first + rows, task.search.height)}, 0, 0, {}, false, {}});
    }
    const auto deadline = task.start + options_.deadline;
    while (Clock::now() < deadline) {
      desk_.wake_when_free(work);
      if (!hand_out(task, work)) break;
      std::unique_lock lock(work->mutex);
      if (work->complete()) break;
      // Silent nodes are not announced by anything.
      constexpr std::chrono::milliseconds kLook{5};
      constexpr std::chrono::milliseconds kLeast{1};
      const auto now = Clock::now();
      auto wake = now + kLook;
      for (const Piece& piece : work->pieces) {
        if (!piece.done && piece.copies > 0) wake = std::min(wake, std::max(piece.due, now + kLeast));
      }
      work->changed.wait_until(lock, std::min(wake, deadline), [&] { return work->woken; });
      work->woken = false;
    }
    const bool sent = std::ranges::any_of(work->pieces, [](const Piece& piece) { return piece.tries > 0; });
    const std::int64_t taken_back = finish(task, *work);
    EdgeField field = merged(task, *work);
    desk_.count_frame(sent, taken_back);
    return field;
  }

  // Gives out what nobody has, then what somebody has had for too long. False when nobody is there, or all that is
  // left has been tried often enough.
  bool hand_out(const FrameTask& task, const std::shared_ptr<FrameWork>& work) {
    constexpr int kMostCopies = 2;
    constexpr int kMostTries = 4;
    bool hope = false;
    std::vector<TileDesk::NodeOffer> offers = desk_.offers();
    const auto now = Clock::now();
    for (std::size_t i = 0; i < work->pieces.size(); ++i) {
      bool second = false;
      {
        const std::scoped_lock lock(work->mutex);
        const Piece& piece = work->pieces[i];
        second = piece.copies > 0;
        hope = hope || (!piece.done && (piece.copies > 0 || piece.tries < kMostTries));
        if (piece.done || piece.tries >= kMostTries || piece.copies >= kMostCopies ||
            (piece.copies > 0 && now < piece.due))
          continue;
      }
      // A second copy goes only to who has nothing else to do: otherwise it is work taken from other tiles.
      const auto takes = [&](const TileDesk::NodeOffer& to) { return !second || to.open == 0; };
      const Rows rows = work->pieces[i].rows;
      const double pixels = task.pixels_in(rows);
      const auto ms = [&](const TileDesk::NodeOffer& to) {
        const double one =
            to.offer.cost.known() ? to.offer.cost.ms(pixels) : pixels / std::max(1.0, to.claimed_pixels_per_ms);
        return one * (to.open + 1);
      };
      const TileDesk::NodeOffer* best = nullptr;
      for (const TileDesk::NodeOffer& to : offers) {
        if (takes(to) && (best == nullptr || ms(to) < ms(*best))) best = &to;
      }
      if (best == nullptr) continue;
      send(task, rows, *best, work, i);
      offers = desk_.offers();
    }
    return hope && !desk_.nodes().empty();
  }

  // Where edges lie depends on the part's colour in the whole frame: they are located now that all are there.
  static EdgeField merged(const FrameTask& task, FrameWork& work) {
    EdgeField field;
    field.searched = task.search;
    field.parts.resize(task.parts.size());
    const auto found = Clock::now();
    {
      const std::scoped_lock lock(work.mutex);
      for (Piece& piece : work.pieces) append(field.parts, std::move(piece.parts));
    }
    for (std::size_t i = 0; i < task.parts.size(); ++i) {
      locate_edges(task.image, task.search, make_gate(task.parts[i]), task.options.transfer, field.parts[i].edges);
    }
    field.times = {{"tiles", std::chrono::duration<double, std::milli>(found - task.start).count()},
                   {"locate", ms_since(found)}};
    return field;
  }

  std::unique_ptr<Backend> local_;
  ClusterOptions options_;
  std::mutex mutex_;
  HomeCosts home_;
  ShareJudge judge_;
  int frames_to_probe_ = 0;
  bool small_probe_ = false;
  std::atomic<std::size_t> frames_underway_ = 0;
  TileDesk desk_;
};

}  // namespace

bool ClusterOptions::is_valid(std::string* why) const {
  const auto refuse = [why](std::string reason) {
    if (why != nullptr) *why = std::move(reason);
    return false;
  };
  if (!connection.is_valid(why)) return false;
  if (deadline.count() <= 0) {
    return refuse("the deadline is " + std::to_string(deadline.count()) + " ms; must be above 0");
  }
  if (tile_rows < 0) return refuse("tile_rows is " + std::to_string(tile_rows) + "; must be at least 0");
  return true;
}

std::unique_ptr<ClusterBackend> make_cluster_backend(std::unique_ptr<Backend> local, const ClusterOptions& options) {
  if (std::string why; !options.is_valid(&why)) {
    throw Error(ErrorKind::kInput, "options of the cluster backend: " + why);
  }
  if (local == nullptr)
    throw Error(ErrorKind::kInput, "the cluster backend needs a local one for what nodes do not do");
  return std::make_unique<Coordinator>(std::move(local), options);
}

}  // namespace cylpose::cluster
