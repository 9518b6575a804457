// Colours, of Okabe and Ito's palette where they carry meaning: people who are colour-blind tell them apart.

const kLight = {
  page: '#ffffff', scene: '#f3f4f6', ink: '#1c1e24', soft: '#5b606b', line: '#d5d8de', ground: '#c9ccd3', grid: '#b4b8c1',
  robot: '#7d9fc4', base: '#8d97a6', held: '#2b9e77', worlds: ['#c8b08a', '#9db58c', '#cf9a84', '#8db3ab', '#c58fa2', '#b5b36b', '#a39bb8', '#aeb2b8'], deforming: '#b48cc0',
  start: '#0072b2', goal: '#d98a00', nearest: '#c8102e', edge: '#ffffff', proven: '#0072b2', measured: '#3f5d75', self: '#8c4fbf', margin: '#a03060', selected: '#f0c800', trail: '#009e73', search: '#8a6d3b', collision: '#d3202a', compared: '#a3268f', outline: '#0b4a36', swept: '#4a90d9', visual: '#d9dbe0',
};
const kDark = {
  page: '#15171b', scene: '#1b1e23', ink: '#eceef2', soft: '#a3a9b5', line: '#3a3e47', ground: '#33373f', grid: '#474c56',
  robot: '#6f9bc9', base: '#7b8696', held: '#35b58a', worlds: ['#a08a62', '#7a9669', '#ac755e', '#67918a', '#a26b7f', '#91904c', '#7f7796', '#868b93'], deforming: '#a878b8',
  start: '#56b4e9', goal: '#e69f00', nearest: '#ff5a5f', edge: '#ffffff', proven: '#56b4e9', measured: '#9fb6cb', self: '#b98be0', margin: '#e58ab0', selected: '#f0e442', trail: '#2fc79a', search: '#c9a86a', collision: '#ff4d55', compared: '#e07bd0', outline: '#c9ffe9', swept: '#3f86cf', visual: '#c3c7cf',
};

export const joints = ['#2f86c9', '#d55e00', '#009e73', '#cc79a7', '#b39200', '#56b4e9', '#7c7c86', '#a06ad0'];

const dark = window.matchMedia('(prefers-color-scheme: dark)');
export const colours = () => (dark.matches ? kDark : kLight);
export const onThemeChange = (then) => dark.addEventListener('change', then);
