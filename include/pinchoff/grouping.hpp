// Bodies put into groups, such that no two of different groups can meet: their boxes do not overlap
// and no link joins them.
#pragma once

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "neighbours.hpp"

namespace pinchoff {

class Grouping {
public:
    /// Groups anew. `links`: bodies that belong together wherever they are; `together`: all do.
    void find(const std::vector<Box>& boxes, const Period& period,
              std::span<const std::pair<int, int>> links, bool together) {
        parent_.resize(boxes.size());
        std::iota(parent_.begin(), parent_.end(), 0);
        finder_.find(boxes, period, pairs_);
        for (const DropletPair& p : pairs_) join(p.first, p.second);
        for (const auto& [one, other] : links) join(one, other);
        for (std::size_t i = 1; i < boxes.size() && together; ++i) join(0, static_cast<int>(i));
        collect();
    }

    /// The bodies of every group, in ascending order; the groups in that of their first bodies.
    const std::vector<std::vector<int>>& groups() const { return groups_; }

    /// The number of a body's group.
    int group_of(int body) { return number_[root(body)]; }

private:
    std::vector<int> parent_;  // of the union of bodies; a root is the first of its group
    std::vector<int> number_;  // of the group, for a root
    std::vector<std::vector<int>> groups_;
    std::vector<DropletPair> pairs_;
    PairFinder finder_;

    int root(int i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }

    void join(int i, int j) {
        i = root(i);
        j = root(j);
        parent_[std::max(i, j)] = std::min(i, j);
    }

    void collect() {
        number_.assign(parent_.size(), -1);
        groups_.clear();
        for (int i = 0; i < static_cast<int>(parent_.size()); ++i) {
            int& number = number_[root(i)];
            if (number < 0) {
                number = static_cast<int>(groups_.size());
                groups_.emplace_back();
            }
            groups_[number].push_back(i);
        }
    }
};

}  // namespace pinchoff
