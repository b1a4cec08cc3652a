// What answers a question comes before what tells of the project, in the site's search.
var Scorer = {
  score: ([page, , , , score]) =>
    score + (/^(how-to|tutorials|reference)\/(?!generated)/.test(page) ? 3 : 0)
          - (/^(changelog|tree|architecture)$/.test(page) ? 30 : 0),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
